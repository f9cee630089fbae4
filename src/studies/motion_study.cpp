#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "jaculus/core/angle.h"
#include "studies/setup.h"
#include "studies/study_kind.h"

// Studies of kind `motion`: the course of a reorientation over time, as Fig. 6 of Norby et al. 2021
// shows it.
//   base: {...}                                    as for kind reorientation
//   cases: [{name: as built, set: {...}}, ...]
// Rows are the integrator's own steps, and the stop twice, before and after its impact. Angles and
// rates are those of studies/reorientation.h but for the body's sign, which is turned so that its
// rotation is positive.

namespace jaculus::studies {
namespace {

constexpr double kTolerance = 1e-9;

struct MotionCase {
  std::string name;
  ReorientationSetup setup;
};

std::vector<MotionCase> read_motion(const yaml::Node& root) {
  root.only(detail::with_common_keys({"base", "cases"}));
  const ReorientationSetup base = read_setup(root.at("base"));

  std::vector<MotionCase> cases;
  for (const yaml::Node& node : root.at("cases").items()) {
    node.only({"name", "set"});
    MotionCase c{node.at("name").text(), base};

    for (const MotionCase& other : cases) {
      if (other.name == c.name)
        throw node.at("name").error(fmt::format("\"{}\" is there twice", c.name));
    }

    if (const auto set = node.find("set")) {
      for (const auto& [name, value] : set->entries()) set_from(c.setup, name, value);
    }

    const std::string fault = check_setup(c.setup);
    if (!fault.empty()) throw node.error(fault);
    cases.push_back(c);
  }

  if (cases.empty()) throw root.at("cases").error("an empty list of cases; name one or more");
  return cases;
}

std::string play(const MotionCase& motion) {
  const ReorientationCase c = to_case(motion.setup);
  std::vector<ReorientationSample> history;
  if (!simulate_reorientation(c, kTolerance, &history).converged) {
    throw std::runtime_error("the equations of motion could not be integrated");
  }
  StudyJson rows = StudyJson::array();
  for (const ReorientationSample& s : history) {
    rows.push_back({{"case", motion.name},
                    {"time_s", s.time},
                    {"body_angle_deg", 0.0 - s.body_angle * kDegrees},
                    {"body_rate_rad_s", 0.0 - s.body_rate},
                    {"tail_angle_deg", s.tail_angle * kDegrees},
                    {"tail_rate_rad_s", s.tail_rate},
                    {"joint_torque_N_m", s.joint_torque}});
  }
  return rows.dump();
}

}  // namespace

detail::PreparedStudy detail::prepare_motion(const yaml::Node& root) {
  const auto cases = std::make_shared<const std::vector<MotionCase>>(read_motion(root));
  PreparedStudy study;
  study.description = fmt::format("{} motions", cases->size());
  study.columns = {"case",           "time_s",          "body_angle_deg",  "body_rate_rad_s",
                   "tail_angle_deg", "tail_rate_rad_s", "joint_torque_N_m"};
  study.tasks = count_of(*cases);
  study.task = [cases](int i) { return play((*cases)[i]); };
  study.rows = [](const std::vector<std::string>& bytes) {
    std::vector<StudyJson> rows;
    for (const std::string& b : bytes) {
      for (const StudyJson& row : StudyJson::parse(b)) rows.push_back(row);
    }
    return rows;
  };
  return study;
}

}  // namespace jaculus::studies
