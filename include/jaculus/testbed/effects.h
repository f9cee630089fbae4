#pragma once
// The testbed's effects by name: how a name and its numbers change the MuJoCo robot. Where the
// diagnosis knows the same thing it has the same name and parameters; what is outside its catalogue
// is marked so. The list is one robot's: it holds what acts on parts that the robot has (a tail,
// legs, feet, motors with windings), and the ranges of strengths follow from its motors, masses and
// lengths.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/testbed/changes.h"
#include "jaculus/trajectory/kinds.h"

namespace jaculus::testbed {

struct RobotFiles;

struct BenchParameter {
  std::string name;
  std::string unit;
  /// taken where none is given; of the first, the strength, the value without effect
  double usual = 0.0;
  double lower = 0.0;  ///< what may be drawn or given
  double upper = 0.0;
  bool drawn = false;  ///< whether a blinded case draws it, though it is not the strength
};

struct BenchEffect {
  std::string name;      ///< "tail_compliance"; at one joint only: "leg_coulomb_friction@knee"
  std::string caption;   ///< one line
  bool outside = false;  ///< of the diagnosis' catalogue
  /// the part of the robot where it acts, by the names that a diagnosis uses; empty where that is
  /// several parts or none of them
  std::string component;
  std::vector<BenchParameter> parameters;  ///< the first is the strength, of which the gap grows
  std::vector<trajectory::ExperimentKind> experiments;  ///< where it shows
  std::function<void(const std::vector<double>& values, Changes& changes)> apply;
  /// a push that happens once, outside of the catalogue too: peak, start and length are its
  /// parameters
  bool event = false;
  std::string joint;  ///< planar joint, of what acts at one joint only; else empty
  /// played where it is asked for by name; blinded cases neither draw it nor count it among what
  /// shows like the truth, so that batches keep the draws and measures that they had without it
  bool by_name_only = false;
};

/// Name without the joint: "leg_coulomb_friction" of "leg_coulomb_friction@knee".
std::string name_without_joint(const std::string& name);

/// Effects of a robot. InputError where its folder can't be read.
std::vector<BenchEffect> bench_effects(const std::filesystem::path& robot_folder);
std::vector<BenchEffect> bench_effects(const RobotFiles& robot);
/// null where there is none
const BenchEffect* find_bench_effect(const std::vector<BenchEffect>& effects,
                                     const std::string& name);

/// What an effect's parameters are where none is given.
std::vector<double> usual_values(const BenchEffect& effect);

/// "name:parameter=value,parameter=value" of a robot's effects put on `changes`. Unknown names,
/// values out of range, a missing strength: InputError that names what is allowed.
void apply_effect(const std::string& given, const std::vector<BenchEffect>& effects,
                  Changes& changes);

}  // namespace jaculus::testbed
