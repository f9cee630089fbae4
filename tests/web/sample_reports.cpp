// Writes a report of each kind that takes long to compute, from values made here, for the browser
// test: names that try to break out of the page, and channels of 10,000 samples.
//   sample_reports FOLDER

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "jaculus/model/robot.h"
#include "jaculus/report/dataset_report.h"
#include "jaculus/report/diagnosis_report.h"
#include "jaculus/report/score_report.h"
#include "sample_diagnosis.h"

namespace {

using namespace jaculus;
namespace fs = std::filesystem;

constexpr int kSamples = 10000;
const std::string kHostile =
    "</script><script>window.hacked = 1</script><img src=x "
    "onerror='window.hacked=1'>\"'&\xE2\x80\xA8";

Vector ramp(double end) { return Vector::LinSpaced(kSamples, 0.0, end); }

/// A robot that rocks on its place, logged densely, under a hostile name.
trajectory::Dataset long_log(const model::PlanarModel& model) {
  trajectory::Dataset dataset;
  dataset.experiment = trajectory::ExperimentKind::leap;
  dataset.robot = kHostile;
  dataset.provenance = "made up " + kHostile;
  dataset.controller.kind = trajectory::ControllerKind::feedforward_pd;
  trajectory::Stream stream;
  stream.name = "joints" + kHostile;
  stream.time = ramp(2.0);
  const auto add = [&stream](const std::string& name, const std::string& unit) {
    stream.channels.push_back(name);
    stream.units.push_back(unit);
  };
  for (const model::Coordinate& c : model.coordinates) add(c.name, c.angular ? "rad" : "m");
  for (int k = 0; k < 20; ++k) add("channel_" + std::to_string(k), "V");
  add(kHostile, kHostile);
  stream.values.resize(stream.channels.size(), kSamples);
  for (Eigen::Index c = 0; c < stream.values.rows(); ++c)
    for (int i = 0; i < kSamples; ++i)
      stream.values(c, i) =
          0.3 * std::sin(10.0 * stream.time[i] + static_cast<double>(c)) + 0.01 * std::sin(1e4 * i);
  for (int i = 0; i < kSamples; ++i) {
    for (Eigen::Index c = 0; c < model.size(); ++c) {
      const Bounds& range = model.coordinates[c].range;
      const bool bounded = std::isfinite(range.lower) && std::isfinite(range.upper);
      const double middle = bounded ? 0.5 * (range.lower + range.upper) : 0.25;
      stream.values(c, i) = middle + 0.1 * std::sin(10.0 * stream.time[i] + static_cast<double>(c));
    }
  }
  dataset.trials = {{"trial " + kHostile, {stream}}};
  return dataset;
}

evaluation::ScoreEstimate estimate(double value, int count) {
  return {value, {value - 0.1, value + 0.1}, count};
}

evaluation::Score sample_score() {
  evaluation::Score score;
  score.provenance = kHostile;
  evaluation::Metrics metrics;
  metrics.predictor = "diagnosis";
  for (int i = 0; i < 24; ++i) {
    evaluation::CaseTruth truth;
    truth.case_id = "case_" + std::to_string(i);
    truth.kind = i % 3 == 0 ? "none" : "single";
    if (i % 3 != 0) truth.effects = {i % 2 == 0 ? "tail_compliance" : kHostile};
    truth.strength_in_noise_floors = 0.5 * i;
    evaluation::CaseScore one;
    one.credit = i % 4 == 0 ? 0.0 : 1.0;
    one.stated = i % 4 == 0 ? "none" : "tail_compliance";
    one.confidence = 0.5 + 0.02 * i;
    metrics.scores.push_back(one);
    score.truths.push_back(truth);
    ++metrics.confusion[truth.effects.empty() ? "none" : truth.effects[0]][one.stated];
  }
  metrics.by = {{"credit of singles", estimate(0.8, 16)}, {kHostile, estimate(0.5, 4)}};
  metrics.credit_by_effect = {{"tail_compliance", estimate(0.9, 8)}, {kHostile, estimate(0.6, 8)}};
  metrics.credit_by_strength = {{"1 to 3", estimate(0.4, 5)}, {"3 or more", estimate(0.9, 11)}};
  for (int b = 0; b < 5; ++b)
    metrics.reliability.push_back(
        {{0.2 * b, 0.2 * b + 0.2}, 0.2 * b + 0.1, estimate(0.2 * b + 0.12, 5)});
  metrics.calibration_error = 0.02;
  evaluation::Metrics baseline = metrics;
  baseline.predictor = "baseline";
  score.metrics = {metrics, baseline};
  score.comparisons = {{"baseline", estimate(0.3, 24), estimate(0.1, 24)}};
  return score;
}

void write(const report::Report& report, const fs::path& folder) {
  fs::create_directories(folder);
  report::write_report(report, folder);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  const model::PlanarModel model =
      model::read_robot(model::find_robot("minitaur_tail", fs::current_path())).planar;
  write(report::dataset_report(long_log(model), model, kHostile), folder / "dataset");
  write(report::score_report(sample_score()), folder / "score");
  write(report::diagnosis_report(sample_diagnosis(kHostile), kHostile), folder / "diagnose");
  std::puts("written");
  return 0;
}
