#include "sample_diagnosis.h"

#include <cmath>

#include "diagnosis/noise/noise_model.h"
#include "jaculus/model/robot.h"

namespace jaculus {
namespace {

constexpr int kSamples = 200;
constexpr double kNoise = 0.02;

/// What the plant would do with a frequency of 3 + p: the model has p = 0, the robot 0.4.
double swing(double t, double p) { return 0.5 * std::sin((3.0 + p) * t); }

diagnosis::ObservedDataset sample_dataset(const std::string& name) {
  diagnosis::ObservedDataset observed;
  observed.model =
      model::read_robot(model::find_robot("minitaur_tail", std::filesystem::current_path())).planar;
  observed.dataset.folder = name;
  observed.streams = {"mocap"};
  observed.channels = {{"mocap", "pitch", "rad", false, 0.01},
                       {"mocap", "x", "m", false, 0.01},
                       {"mocap", "z", "m", false, 0.01}};
  for (int trial = 0; trial < 3; ++trial) {
    trajectory::Stream stream{"mocap",
                              100.0,
                              Vector::LinSpaced(kSamples, 0.0, 2.0),
                              {"pitch", "x", "z"},
                              {"rad", "m", "m"},
                              Matrix(3, kSamples)};
    diagnosis::Segment segment;
    segment.trial = trial;
    segment.block.assign(3, 1);
    segment.spacing.assign(3, 0.01);
    for (int i = 0; i < kSamples; ++i) {
      const double value = swing(stream.time[i], 0.4) + kNoise * std::sin(37.0 * i + trial);
      stream.values.col(i) << value, 0.3 * value, 0.3 + 0.1 * value;
    }
    for (int c = 0; c < 3; ++c) {
      segment.time.push_back(stream.time);
      segment.value.push_back(stream.values.row(c).transpose());
    }
    observed.segments.push_back(segment);
    observed.dataset.trials.push_back({name + std::to_string(trial), {stream}});
  }
  observed.window_end = 2.0;
  observed.trials = 3;
  return observed;
}

diagnosis::Prediction predict(const Vector& p) {
  diagnosis::Prediction prediction;
  prediction.valid = true;
  prediction.step = 0.01;
  prediction.values.resize(3, 210);
  for (int i = 0; i < 210; ++i) {
    const double value = swing(0.01 * i, p[0]);
    prediction.values.col(i) << value, 0.3 * value, 0.3 + 0.1 * value;
  }
  return prediction;
}

diagnosis::Localisation sample_where(const std::string& name) {
  diagnosis::Localisation where;
  where.strength = 7.0;
  where.unexplained = 0.1;
  where.channels = {{"mocap", "pitch", "rad", 0.1, kNoise, 5.0, 600, 100.0},
                    {name, name, name, 0.1, kNoise, 5.0, 600, 100.0}};
  where.phases = {{name, 0.0, 1.0, 0.7, {0.5, 0.8}}, {"second", 1.0, 2.0, 0.3, {0.1, 0.4}}};
  for (int c = 0; c < effects::kComponentCount; ++c)
    where.components.push_back(
        {static_cast<effects::Component>(c), c == 0 ? 0.8 : 0.02 * c, {0.0, 0.9}, 0.5, c != 7, {}});
  where.departure.found = true;
  where.departure.time = 0.3;
  where.departure.ci95 = {0.2, 0.4};
  for (int w = 0; w < 4; ++w)
    where.windows.push_back({0.5 * w, 0.5 * w + 0.5, name, true, 2.0 + w, 1.0, 4.0 + w});
  where.force = {{name},
                 {"N m"},
                 Vector::LinSpaced(20, 0.0, 2.0),
                 Matrix::Random(1, 20),
                 Matrix::Constant(1, 20, 0.2)};
  where.notes = {name};
  return where;
}

}  // namespace

diagnosis::Diagnosis sample_diagnosis(const std::string& name) {
  diagnosis::Diagnosis d;
  d.verdict = diagnosis::Verdict::ambiguous;
  d.reasons = {"two effects stand for the gap: " + name};
  d.notes = {name};
  d.effects = {{"tail_compliance", name, 0.6, {{name, "N m/rad", 98.0, {90.0, 107.0}}}, {name}},
               {name, "caption", 0.35, {}, {}}};
  d.ranking = {
      {"tail_compliance", 40.0, 1.2, 0.6}, {name, 39.0, 1.3, 0.35}, {"none", 0.0, 7.0, 0.0}};
  d.gap.valid = true;
  d.gap.over = "trials";
  d.gap.folds = 3;
  d.gap.before = 7.0;
  d.gap.after = 1.2;
  d.gap.shrink = 0.97;
  d.gap.ci95 = {0.9, 0.99};
  d.gap.channels = {{"mocap.pitch", {7.0, 1.2}}, {name, {3.0, 1.0}}};
  d.where = sample_where(name);
  d.next = diagnosis::NextExperiment{name, 12.0};
  diagnosis::Problem problem;
  problem.observations.datasets = {sample_dataset(name)};
  problem.hypotheses.parameters = {{"effect", name, "rad/s", 0.0, 1.0, {}}};
  problem.forward = [](int, int, const Vector& p) { return predict(p); };
  diagnosis::NoiseModel noise;
  noise.alignments = {diagnosis::unaligned(problem.observations.datasets[0])};
  noise.datasets.emplace_back();
  noise.datasets[0].channels.assign(3, {kNoise, 0.0, 0.0});
  d.problem = std::make_shared<const diagnosis::Problem>(problem);
  d.noise = std::make_shared<const diagnosis::NoiseModel>(noise);
  d.none = {{}, Vector::Zero(1)};
  d.model = {{0}, Vector::Constant(1, 0.4)};
  return d;
}

}  // namespace jaculus
