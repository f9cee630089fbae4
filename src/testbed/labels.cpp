#include "testbed/labels.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "jaculus/core/json.h"

namespace jaculus::testbed {
namespace {

using LabelJson = nlohmann::ordered_json;

double label_number(const LabelJson& value) { return value.is_null() ? kNaN : value.get<double>(); }

LabelJson events_json(const std::vector<TrueEvent>& events) {
  LabelJson list = LabelJson::array();
  for (const TrueEvent& event : events) {
    list.push_back(
        {{"joint", event.joint}, {"from", event.from}, {"to", event.to}, {"peak", event.peak}});
  }
  return list;
}

std::vector<TrueEvent> events_of(const LabelJson& json) {
  std::vector<TrueEvent> events;
  if (!json.contains("events")) return events;
  for (const LabelJson& one : json.at("events"))
    events.push_back({one.at("joint"), one.at("from"), one.at("to"), one.at("peak")});
  return events;
}

LabelJson label_json(const CaseLabel& label) {
  LabelJson parameters = LabelJson::array();
  for (const auto& of_one : label.parameters) {
    LabelJson row = LabelJson::array();
    for (const double value : of_one) row.push_back(json_number(value));
    parameters.push_back(row);
  }
  return {{"case_id", label.case_id},
          {"kind", label.kind},
          {"effects", label.effects},
          {"parameters", parameters},
          {"beside", label.beside},
          {"strengths", label.strengths},
          {"legs_apart", label.legs_apart},
          {"strength_in_noise_floors", json_number(label.strength_in_noise_floors)},
          {"parted", label.diverged},
          {"equivalent", label.equivalent},
          {"component", label.component},
          {"experiment", label.experiment},
          {"trials", label.trials},
          {"datasets", label.datasets},
          {"events", events_json(label.events)}};
}

CaseLabel label_of(const LabelJson& json) {
  CaseLabel label;
  label.case_id = json.at("case_id");
  label.kind = json.at("kind");
  label.effects = json.at("effects").get<std::vector<std::string>>();
  for (const LabelJson& row : json.at("parameters")) {
    label.parameters.emplace_back();
    for (const LabelJson& value : row) label.parameters.back().push_back(label_number(value));
  }
  label.strength_in_noise_floors = label_number(json.at("strength_in_noise_floors"));
  label.beside = json.value("beside", std::vector<std::string>());
  label.strengths = json.value("strengths", std::vector<double>());
  label.legs_apart = json.value("legs_apart", 0.0);
  label.diverged = json.value("parted", std::vector<std::string>());
  label.equivalent = json.at("equivalent").get<std::vector<std::string>>();
  label.component = json.at("component");
  label.experiment = json.at("experiment");
  label.trials = json.at("trials");
  label.datasets = json.value("datasets", 1);
  label.events = events_of(json);
  return label;
}

}  // namespace

std::string label_text(const CaseLabel& label) { return label_json(label).dump(); }

std::string sealed_text(const std::vector<std::string>& labels, const std::string& provenance) {
  LabelJson all = {
      {"format", "jaculus-sealed/1"}, {"provenance", provenance}, {"cases", LabelJson::array()}};
  for (const std::string& label : labels) all["cases"].push_back(LabelJson::parse(label));
  return all.dump(1);
}

std::vector<CaseLabel> labels_in(const std::string& sealed, std::string* provenance) {
  const LabelJson json = LabelJson::parse(sealed);
  if (provenance != nullptr) *provenance = json.at("provenance");
  std::vector<CaseLabel> labels;
  for (const LabelJson& one : json.at("cases")) labels.push_back(label_of(one));
  std::sort(labels.begin(), labels.end(),
            [](const CaseLabel& a, const CaseLabel& b) { return a.case_id < b.case_id; });
  return labels;
}

}  // namespace jaculus::testbed
