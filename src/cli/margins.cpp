#include "cli/margins.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/json.h"
#include "report/document/text_table.h"

namespace jaculus::cli {

using Json = nlohmann::ordered_json;

namespace {

struct MarginRow {
  const char* key;
  const char* caption;
  double simulation::Margins::*value;
  double limit;
};

constexpr MarginRow kMarginRows[] = {
    {"friction_share", "friction cone used [-]", &simulation::Margins::friction_share, 1.0},
    {"slip_time_s", "feet slid for [s]", &simulation::Margins::slip_time, kInfinity},
    {"voltage_share", "voltage over the bus's [-]", &simulation::Margins::voltage_share, 1.0},
    {"torque_share", "motor torque over its limit [-]", &simulation::Margins::torque_share, 1.0},
    {"current_share", "current over its limit [-]", &simulation::Margins::current_share, 1.0},
    {"landing_pitch_rad", "landing pitch [rad]", &simulation::Margins::landing_pitch, kInfinity},
    {"speed_m_s", "forward speed at the plan's end [m/s]", &simulation::Margins::speed, kInfinity},
};

}  // namespace

Json perturb_json(const std::vector<simulation::Replay>& all) {
  Json json = {
      {"replays", all.size() - 1}, {"not_done", 0}, {"slipped", 0}, {"margins", Json::object()}};

  int failed = 0, slipped = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    failed += all[i].margins.status != simulation::SimulationStatus::done ? 1 : 0;
    slipped += all[i].margins.slip_time > 0.0 ? 1 : 0;
  }

  json["not_done"] = failed;
  json["slipped"] = slipped;
  for (const MarginRow& row : kMarginRows) {
    std::vector<double> drawn;
    int at_limit = 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
      const double value = all[i].margins.*row.value;
      if (std::isfinite(value)) drawn.push_back(value);
      at_limit += value >= row.limit * (1.0 - 1e-6) ? 1 : 0;
    }
    std::sort(drawn.begin(), drawn.end());
    const auto quantile = [&](double q) {
      return drawn.empty() ? Json(nullptr)
                           : Json(drawn[static_cast<std::size_t>(
                                 q * static_cast<double>(drawn.size() - 1) + 0.5)]);
    };
    json["margins"][row.key] = {{"nominal", json_number(all.front().margins.*row.value)},
                                {"least", quantile(0.0)},
                                {"median", quantile(0.5)},
                                {"largest", quantile(1.0)},
                                {"at_limit", at_limit}};
  }

  return json;
}

std::string perturb_text(const Json& json) {
  report::TextTable table({"margin", "nominal", "least", "median", "largest", "at the limit"});
  for (const MarginRow& row : kMarginRows) {
    const Json& m = json["margins"][row.key];
    table.row({row.caption, report::json_cell(m["nominal"]), report::json_cell(m["least"]),
               report::json_cell(m["median"]), report::json_cell(m["largest"]),
               std::isfinite(row.limit)
                   ? fmt::format("{} of {}", m["at_limit"].get<int>(), json["replays"].get<int>())
                   : "-"});
  }
  return fmt::format(
      "{} replays under the stated uncertainties: feet slipped in {}, {} did not end\n{}",
      json["replays"].get<int>(), json["slipped"].get<int>(), json["not_done"].get<int>(),
      table.text());
}

}  // namespace jaculus::cli
