#include "diagnosis/remainder/remainder.h"

#include <array>
#include <cmath>

#include "diagnosis/remainder/describe.h"
#include "diagnosis/validation/fold_interval.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::array kNames = {"constant",
                               "sign of speed",
                               "speed",
                               "speed squared",
                               "motor torque",
                               "motor torque against the motion",
                               "weight against the motion",
                               "position",
                               "periodic in position",
                               "gravity direction",
                               "acceleration",
                               "time",
                               "other speed",
                               "other acceleration",
                               "channel",
                               "periodic in time"};

}  // namespace

const char* to_text(Regressor regressor) { return kNames.at(static_cast<std::size_t>(regressor)); }

void set_share(const HeldOut& gap, const Settings& settings, Remainder& remainder) {
  if (!gap.valid || gap.before < settings.plain_gap) return;
  std::vector<double> by_fold;
  for (const FoldGap& fold : gap.by_fold)
    if (fold.before > settings.gap_of_fold) by_fold.push_back(energy_left(fold.before, fold.after));
  remainder.share = energy_left(gap.before, gap.after);
  remainder.ci95 = fold_interval(by_fold, remainder.share);
}

std::vector<RemainderPlace> described_places(const Problem& all,
                                             const std::vector<std::vector<MotionBox>>& boxes) {
  std::vector<std::string> names;
  for (const ObservedDataset& observed : all.observations.datasets)
    for (const model::Coordinate& coordinate : observed.model.coordinates)
      if (index_of(names, coordinate.name) < 0) names.push_back(coordinate.name);

  std::vector<RemainderPlace> places;
  for (const std::string& name : names) {
    const PlaceRegressors place = regressors_of(all, boxes, name);
    if (place.boxes.run.empty()) continue;
    Settings settings = all.settings;
    settings.pattern_level /= static_cast<double>(names.size());
    places.push_back(describe(place, settings));
  }
  return places;
}

}  // namespace jaculus::diagnosis
