#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "studies/setup.h"
#include "studies/study_kind.h"

namespace jaculus::studies::detail {
namespace {

// A scalar as number where it reads as one, else as text.
StudyJson scalar(const yaml::Node& node) {
  if (!node.is_scalar()) throw node.error("must be a number or a text");
  std::string written = node.dump();
  written.resize(written.find_last_not_of(" \t\n\v\f\r") + 1);  // of nothing but these: npos + 1
  char* end = nullptr;
  const double value = std::strtod(written.c_str(), &end);
  if (!written.empty() && end == written.c_str() + written.size() && std::isfinite(value))
    return value;
  return node.text();
}

// Half a unit of the last digit as written, which is all that a printed number claims: 0.302 ->
// 0.0005, 37 -> 0.5.
double half_last_digit(std::string written) {
  const std::size_t exponent = written.find_first_of("eE");
  const double power =
      exponent == std::string::npos ? 0.0 : std::strtod(written.c_str() + exponent + 1, nullptr);
  written = written.substr(0, exponent);
  const std::size_t point = written.find('.');
  const std::size_t last = written.find_last_of("0123456789");
  const double decimals =
      point == std::string::npos || last < point ? 0.0 : static_cast<double>(last - point);
  return 0.5 * std::pow(10.0, power - decimals);
}

double read_within(const yaml::Node& node, const StudyJson& paper) {
  if (const auto within = node.find("within")) {
    if (!paper.is_number())
      throw within->error("given with a paper's figure that is no number; allowed: a number there");
    return within->number(dimension::none, kNotNegative);
  }
  return paper.is_number() ? half_last_digit(node.at("paper").dump()) : kNaN;
}

// Names a figure that is further from the paper's than `within`.
void judge(const ReferenceQuery& q, StudyReference& r, std::vector<std::string>& notes) {
  if (!r.paper.is_number() || !r.computed.is_number()) return;
  const double paper = r.paper.get<double>();
  const double computed = r.computed.get<double>();
  if (paper != 0.0) r.deviation = (computed - paper) / std::abs(paper);
  r.disagrees = !(std::abs(computed - paper) <= q.within * (1.0 + 1e-9));
  if (!r.disagrees) return;
  notes.push_back(fmt::format("disagrees with the paper: {}: {:g} there, {:.5g} here{}{}{}",
                              r.quantity, paper, computed,
                              paper != 0.0 ? fmt::format(" ({:+.1f} %)", 100.0 * r.deviation) : "",
                              r.note.empty() ? "" : "; ", r.note));
}

StudyJson read_where(const yaml::Node& node, const std::vector<std::string>& columns) {
  StudyJson where = StudyJson::object();
  for (const auto& [column, value] : node.entries()) {
    must_be_column(column, columns, value);
    where[column] = scalar(value);
  }
  return where;
}

bool equal(const StudyJson& a, const StudyJson& b) {
  if (a.is_number() && b.is_number()) {
    const double x = a.get<double>();
    const double y = b.get<double>();
    return std::abs(x - y) <= 1e-9 * std::max(std::abs(x), std::abs(y));
  }
  return a == b;
}

// The figure of the row that `where` picks; null with a note where that is not one row.
StudyJson pick(const StudyJson& where, const std::string& column, const ReferenceQuery& query,
               const std::vector<StudyJson>& rows, std::vector<std::string>& notes) {
  const StudyJson* found = nullptr;
  int matches = 0;

  for (const StudyJson& row : rows) {
    const bool match =
        std::all_of(where.items().begin(), where.items().end(),
                    [&](const auto& item) { return equal(row.at(item.key()), item.value()); });
    if (!match) continue;

    ++matches;
    if (query.at_largest.empty() || found == nullptr) {
      found = &row;
    } else if (row.at(query.at_largest).is_number() &&
               (!found->at(query.at_largest).is_number() ||
                row.at(query.at_largest).get<double>() >
                    found->at(query.at_largest).get<double>())) {
      found = &row;
    }
  }

  if (found == nullptr || (query.at_largest.empty() && matches > 1)) {
    const std::string fault =
        fmt::format("{} picks {} rows; it must pick one", where.dump(), matches);
    notes.emplace_back(query.node.error(fault).what());
    return nullptr;
  }

  return found->at(column);
}

}  // namespace

void must_be_column(const std::string& name, const std::vector<std::string>& columns,
                    const yaml::Node& where) {
  if (std::find(columns.begin(), columns.end(), name) != columns.end()) return;
  const auto near = yaml::nearest_name(name, columns);
  throw where.error(fmt::format("this study has no column \"{}\"{}", name,
                                near ? fmt::format("; did you mean \"{}\"?", *near)
                                     : fmt::format("; it has {}", fmt::join(columns, ", "))));
}

std::vector<ReferenceQuery> read_references(const yaml::Node& root,
                                            const std::vector<std::string>& columns) {
  std::vector<ReferenceQuery> queries;
  const auto list = root.find("reference");
  if (!list) return queries;

  for (const yaml::Node& node : list->items()) {
    node.only({"quantity", "paper", "column", "where", "over", "over_column", "at_largest",
               "within", "note"});
    ReferenceQuery q;
    q.node = node;
    q.quantity = node.at("quantity").text();
    q.paper = scalar(node.at("paper"));
    q.column = node.at("column").text();
    must_be_column(q.column, columns, node.at("column"));

    q.where = node.has("where") ? read_where(node.at("where"), columns) : StudyJson::object();
    q.over_column = q.column;
    if (node.has("over_column")) {
      q.over_column = node.at("over_column").text();
      must_be_column(q.over_column, columns, node.at("over_column"));
      q.over = q.where;
    }

    if (node.has("over")) q.over = read_where(node.at("over"), columns);
    if (node.has("at_largest")) {
      q.at_largest = node.at("at_largest").text();
      must_be_column(q.at_largest, columns, node.at("at_largest"));
    }

    q.within = read_within(node, q.paper);
    if (node.has("note")) q.note = node.at("note").text();
    queries.push_back(q);
  }
  return queries;
}

StudyReference evaluate(const ReferenceQuery& q, const std::vector<StudyJson>& rows,
                        std::vector<std::string>& notes) {
  StudyReference r{q.quantity, q.paper, pick(q.where, q.column, q, rows, notes), q.note, q.column};
  if (!q.over.is_null()) {
    const StudyJson other = pick(q.over, q.over_column, q, rows, notes);
    const bool numbers = r.computed.is_number() && other.is_number();
    r.computed =
        numbers ? json_number(r.computed.get<double>() / other.get<double>()) : StudyJson(nullptr);
  }
  judge(q, r, notes);
  return r;
}

}  // namespace jaculus::studies::detail
