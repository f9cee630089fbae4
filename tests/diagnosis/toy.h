#pragma once
// A problem without a robot: channels that are sums of known shapes, so that every answer of the
// statistics is known.

#include <cmath>
#include <memory>
#include <random>

#include "diagnosis/noise/noise_model.h"

namespace jaculus::test {

/// Two channels over 0.5 s, "a" and "b". Candidates bend them: `first` (one-sided), `second`,
/// `twin` (the shape of `first` twice) and `blind` (nothing). Values of true parameters: p =
/// (first, second, twin, blind).
inline Vector toy_shape(int channel, const Vector& time, const Vector& p) {
  const Vector s = time.cwiseMax(0.0) / 0.5;
  const Vector motion = channel == 0 ? Vector(s.array().square()) : Vector(s.array().sin());
  const Vector first = channel == 0 ? Vector(s.array().cube()) : Vector(-0.5 * s.array().square());
  const Vector second =
      channel == 0 ? Vector((6.0 * s.array()).sin()) : Vector((4.0 * s.array()).cos() - 1.0);
  return motion + (p[0] + 2.0 * p[2]) * first + p[1] * second;
}

struct ToyData {
  int segments = 5;
  double noise = 1e-3;
  unsigned seed = 1;
  std::function<double(int channel, double time)> extra;  ///< that no candidate has
  int pushed = -1;  ///< segment that leaves the others at 0.3 s
};

/// Both channels on a grid of 1 ms, of parameters of the shapes.
inline diagnosis::Prediction toy_prediction(const Vector& p) {
  diagnosis::Prediction prediction;
  prediction.valid = true;
  prediction.step = 1e-3;
  const Vector time = Vector::LinSpaced(531, 0.0, 0.53);
  prediction.values.resize(2, time.size());
  for (int c = 0; c < 2; ++c) prediction.values.row(c) = toy_shape(c, time, p).transpose();
  return prediction;
}

inline std::shared_ptr<diagnosis::Problem> toy_problem(const Vector& truth,
                                                       const ToyData& data = {}) {
  auto problem = std::make_shared<diagnosis::Problem>();
  diagnosis::ObservedDataset dataset;
  dataset.streams = {"mocap"};
  for (const char* name : {"a", "b"}) {
    diagnosis::Channel channel;
    channel.stream = "mocap";
    channel.name = name;
    channel.unit = "m";
    channel.spacing = 0.005;
    dataset.channels.push_back(channel);
  }
  dataset.window_start = -0.05;
  dataset.window_end = 0.5;
  dataset.trials = data.segments;
  std::mt19937 generator(data.seed);
  std::normal_distribution<double> normal(0.0, data.noise);
  for (int r = 0; r < data.segments; ++r) {
    diagnosis::Segment segment;
    segment.trial = r;
    segment.prefix_end = 0.125;
    for (int c = 0; c < 2; ++c) {
      const Vector time = Vector::LinSpaced(111, -0.05, 0.5);
      Vector value = toy_shape(c, time, truth);
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        value[i] += normal(generator) + (data.extra ? data.extra(c, time[i]) : 0.0);
        if (r == data.pushed && time[i] > 0.3)
          value[i] += 40.0 * data.noise * (time[i] - 0.3) / 0.1;
      }
      segment.time.push_back(time);
      segment.value.push_back(value);
      segment.block.push_back(1);
      segment.spacing.push_back(0.005);
    }
    dataset.dataset.trials.push_back({"trial_" + std::to_string(r + 1), {}});
    dataset.segments.push_back(segment);
  }
  problem->observations.datasets.push_back(dataset);
  diagnosis::Hypotheses& h = problem->hypotheses;
  const char* names[] = {"first", "second", "twin", "blind"};
  for (int k = 0; k < 4; ++k) {
    diagnosis::FreeParameter p{names[k], "strength", "-", 0.0, 0.1, {k == 1 ? -1.0 : 0.0, 1.0}};
    h.parameters.push_back(p);
    diagnosis::Candidate candidate;
    candidate.name = names[k];
    candidate.parameters = {k};
    h.candidates.push_back(candidate);
  }
  problem->forward = [](int, int, const Vector& p) { return toy_prediction(p); };
  return problem;
}

inline Vector toy_truth(double first, double second) {
  Vector truth = Vector::Zero(4);
  truth[0] = first;
  truth[1] = second;
  return truth;
}

}  // namespace jaculus::test
