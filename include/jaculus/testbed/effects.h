#pragma once
// The testbed's effects by name: how a name and its numbers change the MuJoCo robot. Where the diagnosis knows the same thing it
// has the same name and parameters; what is outside its catalogue is marked so.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/testbed/changes.h"

namespace jaculus::testbed {

struct BenchParameter {
  std::string name;
  std::string unit;
  double usual = 0.0;  ///< taken where none is given; of the first, the strength, the value without effect
  double lower = 0.0;  ///< what may be drawn or given
  double upper = 0.0;
};

struct BenchEffect {
  std::string name;                        ///< "tail_compliance"
  std::string caption;                     ///< one line
  bool outside = false;                    ///< of the diagnosis' catalogue
  std::vector<BenchParameter> parameters;  ///< the first is the strength, of which the gap grows
  std::vector<std::string> experiments;    ///< where it shows
  std::function<void(const std::vector<double>& values, Changes& changes)> apply;
};

const std::vector<BenchEffect>& bench_effects();
const BenchEffect* find_bench_effect(const std::string& name);  ///< null where there is none

/// What an effect's parameters are where none is given.
std::vector<double> usual_values(const BenchEffect& effect);

/// The part of the robot where it acts, by the names that a diagnosis uses; empty where that is several parts or none of them.
std::string bench_component(const std::string& effect);

/// "name:parameter=value,parameter=value" (or "name" alone where no strength is needed) put on `changes`. Unknown names, values
/// out of range, a missing strength: InputError that names what is allowed.
void apply_effect(const std::string& given, Changes& changes);

}  // namespace jaculus::testbed
