#include "report/document/json.h"

#include <bit>
#include <cassert>
#include <cstring>

#include "jaculus/core/installation.h"
#include "jaculus/core/json.h"
#include "jaculus/core/names.h"

namespace jaculus::report {
namespace {

using Json = nlohmann::ordered_json;
static_assert(std::endian::native == std::endian::little,
              "arrays are written as the machine holds them");

std::string base64(const std::vector<float>& values) {
  static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes(values.size() * sizeof(float));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned block = static_cast<unsigned>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) block |= static_cast<unsigned>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) block |= bytes[i + 2];
    for (std::size_t k = 0; k < 4; ++k) {
      const bool padding = i + k > bytes.size();
      text += padding ? '=' : kDigits[block >> (18 - 6 * k) & 63U];
    }
  }
  return text;
}

Json axis(const ChartAxis& a) {
  return {{"name", a.name},
          {"unit", a.unit},
          {"log", a.logarithmic},
          {"range", {json_number(a.range.lower), json_number(a.range.upper)}}};
}

const NameTable<SeriesStyle>& series_styles() {
  static const NameTable<SeriesStyle> table({{SeriesStyle::line, "line"},
                                             {SeriesStyle::dashed, "dashed"},
                                             {SeriesStyle::points, "points"},
                                             {SeriesStyle::steps, "steps"}});
  return table;
}

const NameTable<MarkKind>& mark_kinds() {
  static const NameTable<MarkKind> table(
      {{MarkKind::published, "published"}, {MarkKind::limit, "limit"}, {MarkKind::note, "note"}});
  return table;
}

const NameTable<BodyKind>& body_kinds() {
  static const NameTable<BodyKind> table({{BodyKind::base, "base"},
                                          {BodyKind::leg, "leg"},
                                          {BodyKind::tail, "tail"},
                                          {BodyKind::scoop, "scoop"},
                                          {BodyKind::link, "link"}});
  return table;
}

Json chart(const Chart& c, NumberArrays& arrays) {
  Json json = {{"id", c.id},         {"title", c.title},        {"caption", c.caption},
               {"x", axis(c.x)},     {"y", axis(c.y)},          {"overTime", c.over_time},
               {"figure", c.figure}, {"series", Json::array()}, {"marks", Json::array()}};
  for (const Series& s : c.series) {
    assert(s.x.size() == s.y.size());
    json["series"].push_back({{"name", s.name},
                              {"style", series_styles().name(s.style)},
                              {"colour", s.colour},
                              {"x", arrays.add(s.x)},
                              {"y", arrays.add(s.y)},
                              {"low", arrays.add(s.low)},
                              {"high", arrays.add(s.high)}});
  }

  for (const Mark& m : c.marks) {
    json["marks"].push_back({{"label", m.label},
                             {"kind", mark_kinds().name(m.kind)},
                             {"x", json_number(m.x)},
                             {"y", json_number(m.y)},
                             {"xTo", json_number(m.x_to)}});
  }

  return json;
}

Json table(const ReportTable& t) {
  return {{"title", t.title}, {"columns", t.columns}, {"rows", t.rows}, {"note", t.note}};
}

Json bars(const Bars& b) {
  Json json = {{"id", b.id},
               {"title", b.title},
               {"unit", b.unit},
               {"caption", b.caption},
               {"items", Json::array()}};
  for (const Bars::Item& i : b.items) {
    json["items"].push_back({{"label", i.label},
                             {"value", json_number(i.value)},
                             {"low", json_number(i.low)},
                             {"high", json_number(i.high)},
                             {"note", i.note}});
  }
  return json;
}

Json heat_map(const HeatMap& h) {
  Json values = Json::array();
  for (const auto& row : h.values) {
    Json cells = Json::array();
    for (const double v : row) cells.push_back(json_number(v));
    values.push_back(cells);
  }
  return {{"id", h.id},
          {"title", h.title},
          {"rowTitle", h.row_title},
          {"columnTitle", h.column_title},
          {"rows", h.rows},
          {"columns", h.columns},
          {"values", values},
          {"caption", h.caption}};
}

Json drawing(const Drawing& d) {
  Json json = {{"id", d.id}, {"title", d.title}, {"caption", d.caption}, {"parts", Json::array()}};
  for (const Drawing::Part& p : d.parts) {
    Json line = Json::array();
    for (const Vec2& point : p.line)
      line.push_back({json_number(point.x()), json_number(point.y())});
    json["parts"].push_back({{"name", p.name},
                             {"line", line},
                             {"width", p.width},
                             {"value", json_number(p.value)},
                             {"text", p.text},
                             {"style", p.style}});
  }
  return json;
}

Json pairs(const std::vector<std::pair<std::string, std::string>>& list) {
  Json json = Json::array();
  for (const auto& [name, value] : list) json.push_back({name, value});
  return json;
}

Json picture(const Picture& p) {
  Json json = {{"id", p.id},
               {"title", p.title},
               {"caption", p.caption},
               {"legend", pairs(p.legend)},
               {"panels", Json::array()}};
  for (const Drawing& d : p.panels) json["panels"].push_back(drawing(d));
  return json;
}

Json choice(const Choice& c) {
  Json json = {{"id", c.id},         {"title", c.title},   {"chart", c.chart},
               {"labels", c.labels}, {"chosen", c.chosen}, {"drawings", Json::array()}};
  for (const Drawing& d : c.drawings) json["drawings"].push_back(drawing(d));
  return json;
}

Json actor(const Actor& a, NumberArrays& arrays) {
  Json json = {{"name", a.name},
               {"style", a.style == ActorStyle::ghost ? "ghost" : "solid"},
               {"colour", a.colour},
               {"time", arrays.add(a.time)},
               {"com", arrays.add(a.com)},
               {"feet", a.feet},
               {"friction", json_number(a.friction)}};
  json["bodies"] = Json::array();
  for (const ActorBody& b : a.bodies) {
    assert(b.xz.size() == a.time.size() * static_cast<std::size_t>(b.points) * 2);
    json["bodies"].push_back({{"name", b.name},
                              {"kind", body_kinds().name(b.kind)},
                              {"points", b.points},
                              {"xz", arrays.add(b.xz)}});
  }

  json["arrows"] = Json::array();
  for (const ActorArrow& w : a.arrows) {
    json["arrows"].push_back({{"name", w.name},
                              {"kind", w.kind == ArrowKind::drag ? "drag" : "force"},
                              {"from", arrays.add(w.from)},
                              {"force", arrays.add(w.force)}});
  }

  json["phases"] = Json::array();
  for (const ActorPhase& p : a.phases)
    json["phases"].push_back({{"name", p.name}, {"from", p.from}, {"to", p.to}});
  return json;
}

Json animation(const Animation& a, NumberArrays& arrays) {
  Json json = {{"id", a.id}, {"title", a.title}, {"caption", a.caption}, {"panels", Json::array()}};
  for (const Animation::Panel& p : a.panels) {
    Json panel = {{"title", p.title}, {"actors", Json::array()}};
    for (const Actor& one : p.actors) panel["actors"].push_back(actor(one, arrays));
    json["panels"].push_back(panel);
  }
  return json;
}

Json section(const Section& s, NumberArrays& arrays) {
  Json json = {{"title", s.title}, {"text", s.text}, {"folded", s.folded}};
  const auto list = [&json](const char* key, const auto& items, const auto& one) {
    json[key] = Json::array();
    for (const auto& item : items) json[key].push_back(one(item));
  };
  list("animations", s.animations, [&](const Animation& a) { return animation(a, arrays); });
  list("tables", s.tables, table);
  list("bars", s.bars, bars);
  list("heatMaps", s.heat_maps, heat_map);
  list("drawings", s.drawings, drawing);
  list("charts", s.charts, [&](const Chart& c) { return chart(c, arrays); });
  list("choices", s.choices, choice);
  return json;
}

}  // namespace

Json NumberArrays::add(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  std::string text = base64({values.begin(), values.end()});
  const auto [place, fresh] = index_.try_emplace(std::move(text), count_of(list_));
  if (fresh) list_.push_back(place->first);
  return place->second;
}

Json document_json(const Document& document) {
  NumberArrays arrays;
  Json json = {{"format", "jaculus-report/1"},
               {"version", version()},
               {"title", document.title},
               {"caption", document.caption},
               {"kind", document.kind},
               {"notices", document.notices},
               {"facts", pairs(document.facts)},
               {"summary", pairs(document.summary)},
               {"picture", picture(document.picture)},
               {"sections", Json::array()}};
  for (const Section& s : document.sections) json["sections"].push_back(section(s, arrays));
  json["arrays"] = arrays.list();
  return json;
}

}  // namespace jaculus::report
