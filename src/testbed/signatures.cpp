// How each effect shows on an experiment, at one strength, to compare a case's difference with.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "testbed/draws.h"
#include "testbed/noise_floor.h"

namespace jaculus::testbed {
namespace {

/// Every channel over its noise floor as one vector, gaps of the floor left out; weight for the
/// number of samples is in it.
Vector stacked(const Stage& stage, const trajectory::Dataset& dataset, const SensorSpec& sensors) {
  std::vector<double> out;
  for (const trajectory::Stream& stream : dataset.trials.front().streams) {
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const double floor = channel_floor(stream.channels[c], stream.units[c], sensors, stage.robot);
      if (std::isnan(floor)) continue;
      for (Eigen::Index k = 0; k < stream.values.cols(); ++k) {
        out.push_back(stream.values(c, k) / floor);
      }
    }
  }
  return Eigen::Map<Vector>(out.data(), out.size());
}

/// A fine run in the streams and rates of `like`.
trajectory::Dataset thinned(const trajectory::Dataset& fine, const trajectory::Dataset& like) {
  trajectory::Dataset out = like;
  for (trajectory::Stream& stream : out.trials.front().streams) {
    const trajectory::Stream& from = *fine.trials.front().stream(stream.name);
    const Eigen::Index stride = std::lround(from.rate_hz / stream.rate_hz);
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const int row = from.channel(stream.channels[c]);
      for (Eigen::Index k = 0; k < stream.values.cols(); ++k) {
        stream.values(c, k) = row < 0 ? 0.0 : from.values(row, k * stride);
      }
    }
  }
  return out;
}

/// How the stacked vector changes with the zero of each stream's clock, to second order: two
/// columns a stream.
Matrix clock_directions(const Stage& stage, const Signatures& signatures,
                        const trajectory::Dataset& nominal, const SensorSpec& sensors) {
  const auto& streams = nominal.trials.front().streams;
  Matrix out(stacked(stage, nominal, sensors).size(), 2 * std::ssize(streams));

  Eigen::Index column = 0;
  for (const trajectory::Stream& stream : streams) {
    for (const int order : {1, 2}) {
      trajectory::Dataset moved = signatures.nominal;
      for (trajectory::Stream& each : moved.trials.front().streams) {
        const Matrix was = each.values;
        each.values.setZero();
        if (each.name != stream.name) continue;
        for (Eigen::Index k = 1; k + 1 < was.cols(); ++k) {
          each.values.col(k) = order == 1
                                   ? Vector(0.5 * (was.col(k + 1) - was.col(k - 1)))
                                   : Vector(was.col(k + 1) + was.col(k - 1) - 2.0 * was.col(k));
        }
      }
      out.col(column++) = stacked(stage, thinned(moved, nominal), sensors);
    }
  }

  return out;
}

Vector rest_after(const Matrix& directions, const Vector& difference) {
  return difference - directions * directions.colPivHouseholderQr().solve(difference);
}

}  // namespace

double share_beyond_nuisances(const Stage& stage, const Signatures& signatures,
                              const TrialSpec& spec, const trajectory::Dataset& nominal,
                              const trajectory::Dataset& changed) {
  const Vector difference =
      stacked(stage, changed, spec.sensors) - stacked(stage, nominal, spec.sensors);
  if (difference.norm() == 0.0) return 0.0;
  const Matrix clocks = clock_directions(stage, signatures, nominal, spec.sensors);
  const Eigen::Index rows = difference.size(), starts = signatures.starts.size();

  // Rows below hold the starts to kStartSpread; without them what hardly shows could be as large as
  // it likes.
  Matrix directions = Matrix::Zero(rows + starts, clocks.cols() + starts);
  directions.topLeftCorner(rows, clocks.cols()) = clocks;
  for (Eigen::Index i = 0; i < starts; ++i) {
    const trajectory::Dataset& moved = signatures.starts[i];
    directions.col(clocks.cols() + i).head(rows) =
        stacked(stage, thinned(moved, nominal), spec.sensors) -
        stacked(stage, thinned(signatures.level, nominal), spec.sensors);
    directions(rows + i, clocks.cols() + i) = kStartStep / kStartSpread;
  }

  Vector padded = Vector::Zero(rows + starts);
  padded.head(rows) = difference;
  return rest_after(directions, padded).norm() / difference.norm();
}

double signature_strength(const BenchEffect& effect) {
  const BenchParameter& p = effect.parameters.front();
  const double end = p.upper > p.usual ? p.upper : p.lower;
  // acts only from some strength on
  const bool limit = effect.name == "foot_friction" || effect.name == "current_limit";
  return p.usual + (limit ? 0.6 : 0.1) * (end - p.usual);
}

TrialSpec signature_spec() {
  TrialSpec spec;
  spec.sensors.mocap_rate_hz = 720.0;  // of which 120, 240 and 360 Hz are parts
  spec.sensors.joints_rate_hz = 1000.0;
  spec.sensors.electric = true;
  spec.sensors.imu = true;
  return spec;
}

std::vector<std::string> signature_effects(const Stage& stage) {
  std::vector<std::string> names;
  for (const BenchEffect& effect : stage.effects) {
    // What acts at one joint alone is taken for what it does there: no catalogue states it so yet.
    if (!effect.outside && !effect.by_name_only && effect.joint.empty() &&
        acting_effect(stage, effect.name) != nullptr)
      names.push_back(effect.name);
  }
  return names;
}

std::string signature_bytes(const Stage& stage, const std::string& name) {
  Changes changes;
  if (const BenchEffect* effect = find_bench_effect(stage.effects, name)) {
    std::vector<double> values = usual_values(*effect);
    values[0] = signature_strength(*effect);
    effect->apply(values, changes);
  }
  const std::optional<trajectory::Dataset> run = exact_run(stage, changes, signature_spec());
  std::string bytes;
  if (!run) return bytes;
  for (const trajectory::Stream& stream : run->trials.front().streams) {
    bytes.append(reinterpret_cast<const char*>(stream.values.data()),
                 stream.values.size() * sizeof(double));
  }
  return bytes;
}

Signatures signatures_of(const Stage& stage, const std::vector<std::string>& bytes) {
  Signatures out;
  const std::optional<trajectory::Dataset> layout = exact_run(stage, Changes{}, signature_spec());
  if (layout) out.nominal = *layout;
  for (const std::string& joint : stage.robot.planar_motors) {
    TrialSpec moved = signature_spec();
    moved.start_offset[joint] = 0.0;
    if (const std::optional<trajectory::Dataset> run = exact_run(stage, Changes{}, moved))
      out.level = *run;
    moved.start_offset[joint] = kStartStep;
    if (const std::optional<trajectory::Dataset> run = exact_run(stage, Changes{}, moved))
      out.starts.push_back(*run);
  }

  const std::vector<std::string> names = signature_effects(stage);
  for (std::size_t i = 0; i < names.size() && i < bytes.size(); ++i) {
    if (bytes[i].empty() || !layout) continue;
    trajectory::Dataset run = *layout;
    std::size_t from = 0;
    for (trajectory::Stream& stream : run.trials.front().streams) {
      const std::size_t length = stream.values.size() * sizeof(double);
      std::memcpy(stream.values.data(), bytes[i].data() + from, length);
      from += length;
    }
    out.effects.push_back(names[i]);
    out.runs.push_back(std::move(run));
  }

  return out;
}

}  // namespace jaculus::testbed
