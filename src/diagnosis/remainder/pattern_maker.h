#pragma once
// Patterns of one place (place_patterns.h), with what their formulas share: units, sizes, names.

#include <string>
#include <vector>

#include "diagnosis/remainder/place_patterns.h"

namespace jaculus::diagnosis {

/// A place with what its formulas call force and motion.
struct PatternPlace {
  std::string place, at, where;     ///< as of PlacePattern
  std::string key{};                ///< "torque", "force" of a joint
  std::string force{};              ///< unit; "1" where sizes are shares of each motor's limit
  std::string metre{};              ///< unit of its position
  std::string what{};               ///< of the captions: "torque at elbow"
  double large = 1.0;               ///< that counts as large, times the prior [force]
  bool limited = false;             ///< by torque or current
  double limit = 1.0;               ///< of a motor's torque, where it has one, else large [force]
  double speed = 1.0;               ///< usual [metre/s]
  double start = 0.0, range = 0.0;  ///< [metre]
  double rest = 0.0;                ///< speed below which its sign counts in part [metre/s]
  double duration = 1.0;            ///< of the motion [s]
  bool of_group = false;            ///< of joints together
  std::string body{};               ///< that the joint turns
  double mass = 1.0;                ///< that counts as large, times the prior [kg]
  double turn = kNaN;               ///< of its motor, at the joint [metre]

  /// Of joints of different size a force is so many times `tau_limit` of each.
  [[nodiscard]] bool by_limit() const { return force == "1"; }
};

class PatternMaker {
 public:
  explicit PatternMaker(PatternPlace place) : place_(std::move(place)) {}

  PlacePattern& add(Regressor regressor, const std::string& kind, const std::string& caption,
                    std::vector<PatternParameter> parameters, std::vector<std::string> formulas);
  /// The same of a form that the regressor says only in part: "caption: cause". The catalogue has
  /// no effect of it.
  PlacePattern& add_caused(Regressor regressor, const std::string& kind, const std::string& caption,
                           const std::string& cause, std::vector<PatternParameter> parameters,
                           const std::string& formula);
  /// A parameter in units of force over `per`, whose usual size is `size`.
  [[nodiscard]] PatternParameter parameter(const std::string& name, const std::string& per = {},
                                           double size = 1.0) const;
  /// The same of a cause that has one sign: friction, a cable, a loss.
  [[nodiscard]] PatternParameter one_sided(const std::string& name, const std::string& per = {},
                                           double size = 1.0) const;
  /// A share of a motor's torque that is lost, all of it at most.
  [[nodiscard]] PatternParameter lost() const;
  /// A share of a motor's torque, as large at its limit as a force of the same prior.
  [[nodiscard]] PatternParameter share() const;
  /// The joint's torque or force: so many parameters in units of force, or shares of `tau`.
  [[nodiscard]] std::string line(const std::string& formula) const;
  [[nodiscard]] std::string share_line(const std::string& formula) const;
  /// The speed below which a sign counts in part, as a constant `rest`.
  [[nodiscard]] std::string rest_line() const;
  [[nodiscard]] const PatternPlace& at() const { return place_; }

  std::vector<PlacePattern> made;

 private:
  PatternPlace place_;
};

/// "force: {x: ..., z: ...}" along one axis, with nothing along the other.
std::vector<std::string> along(const std::string& axis, const std::string& formula);

}  // namespace jaculus::diagnosis
