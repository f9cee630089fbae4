// How each effect shows on an experiment, at one strength, to compare a case's difference with.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "jaculus/model/robot.h"
#include "testbed/draws.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {
namespace {

/// Every channel over its noise floor as one vector, gaps of the floor left out; weight for the number of samples is in it.
Vector stacked(const Dataset& dataset, const SensorSpec& sensors) {
  std::vector<double> out;
  for (const Stream& stream : dataset.trials.front().streams) {
    for (std::size_t c = 0; c < stream.channels.size(); ++c) {
      const double floor = channel_floor(stream.channels[c], stream.units[c], sensors);
      if (std::isnan(floor)) continue;
      for (Eigen::Index k = 0; k < stream.values.cols(); ++k) {
        out.push_back(stream.values(static_cast<Eigen::Index>(c), k) / floor);
      }
    }
  }
  return Eigen::Map<Vector>(out.data(), static_cast<Eigen::Index>(out.size()));
}

/// A fine run in the streams and rates of `like`.
Dataset thinned(const Dataset& fine, const Dataset& like) {
  Dataset out = like;
  for (Stream& stream : out.trials.front().streams) {
    const Stream& from = *fine.trials.front().stream(stream.name);
    const auto stride = static_cast<Eigen::Index>(std::lround(from.rate_hz / stream.rate_hz));
    for (std::size_t c = 0; c < stream.channels.size(); ++c) {
      const int row = from.channel(stream.channels[c]);
      for (Eigen::Index k = 0; k < stream.values.cols(); ++k) {
        stream.values(static_cast<Eigen::Index>(c), k) = row < 0 ? 0.0 : from.values(row, k * stride);
      }
    }
  }
  return out;
}

/// How the stacked vector changes with the zero of each stream's clock, to second order: two columns a stream.
Matrix clock_directions(const Signatures& signatures, const Dataset& nominal, const SensorSpec& sensors) {
  const auto& streams = nominal.trials.front().streams;
  Matrix out(stacked(nominal, sensors).size(), 2 * static_cast<Eigen::Index>(streams.size()));
  Eigen::Index column = 0;
  for (const Stream& stream : streams) {
    for (const int order : {1, 2}) {
      Dataset moved = signatures.nominal;
      for (Stream& each : moved.trials.front().streams) {
        const Matrix was = each.values;
        each.values.setZero();
        if (each.name != stream.name) continue;
        for (Eigen::Index k = 1; k + 1 < was.cols(); ++k) {
          each.values.col(k) = order == 1 ? Vector(0.5 * (was.col(k + 1) - was.col(k - 1)))
                                          : Vector(was.col(k + 1) + was.col(k - 1) - 2.0 * was.col(k));
        }
      }
      out.col(column++) = stacked(thinned(moved, nominal), sensors);
    }
  }
  return out;
}

Vector rest_after(const Matrix& directions, const Vector& difference) {
  return difference - directions * directions.colPivHouseholderQr().solve(difference);
}

}  // namespace

double share_beyond_nuisances(const Signatures& signatures, const TrialSpec& spec, const Dataset& nominal,
                              const Dataset& changed) {
  const Vector difference = stacked(changed, spec.sensors) - stacked(nominal, spec.sensors);
  if (difference.norm() == 0.0) return 0.0;
  const Matrix clocks = clock_directions(signatures, nominal, spec.sensors);
  const Eigen::Index rows = difference.size(), starts = static_cast<Eigen::Index>(signatures.starts.size());
  // Rows below hold the starts to kStartSpread; without them what hardly shows could be as large as it likes.
  Matrix directions = Matrix::Zero(rows + starts, clocks.cols() + starts);
  directions.topLeftCorner(rows, clocks.cols()) = clocks;
  for (Eigen::Index i = 0; i < starts; ++i) {
    const Dataset& moved = signatures.starts[static_cast<std::size_t>(i)];
    directions.col(clocks.cols() + i).head(rows) =
        stacked(thinned(moved, nominal), spec.sensors) - stacked(thinned(signatures.level, nominal), spec.sensors);
    directions(rows + i, clocks.cols() + i) = kStartStep / kStartSpread;
  }
  Vector padded = Vector::Zero(rows + starts);
  padded.head(rows) = difference;
  return rest_after(directions, padded).norm() / difference.norm();
}

double signature_strength(const std::string& name) {
  const BenchParameter& p = find_bench_effect(name)->parameters.front();
  const double end = p.upper > p.usual ? p.upper : p.lower;
  const bool limit = name == "foot_friction" || name == "current_limit";  // acts only from some strength on
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
  for (const BenchEffect& effect : bench_effects()) {
    if (!effect.outside && can_act(effect, stage)) names.push_back(effect.name);
  }
  return names;
}

std::string signature_bytes(const Stage& stage, const std::string& name) {
  Changes changes;
  if (const BenchEffect* effect = find_bench_effect(name)) {
    std::vector<double> values = usual_values(*effect);
    values[0] = signature_strength(name);
    effect->apply(values, changes);
  }
  const std::optional<Dataset> run = exact_run(stage, changes, signature_spec());
  std::string bytes;
  if (!run) return bytes;
  for (const Stream& stream : run->trials.front().streams) {
    bytes.append(reinterpret_cast<const char*>(stream.values.data()),
                 static_cast<std::size_t>(stream.values.size()) * sizeof(double));
  }
  return bytes;
}

Signatures signatures_of(const Stage& stage, const std::vector<std::string>& bytes) {
  Signatures out;
  const std::optional<Dataset> layout = exact_run(stage, Changes{}, signature_spec());
  if (layout) out.nominal = *layout;
  for (const std::string& joint : read_robot_files(find_robot(stage.asked.robot, stage.asked.folder)).planar_motors) {
    TrialSpec moved = signature_spec();
    moved.start_offset[joint] = 0.0;
    if (const std::optional<Dataset> run = exact_run(stage, Changes{}, moved)) out.level = *run;
    moved.start_offset[joint] = kStartStep;
    if (const std::optional<Dataset> run = exact_run(stage, Changes{}, moved)) out.starts.push_back(*run);
  }
  const std::vector<std::string> names = signature_effects(stage);
  for (std::size_t i = 0; i < names.size() && i < bytes.size(); ++i) {
    if (bytes[i].empty() || !layout) continue;
    Dataset run = *layout;
    std::size_t from = 0;
    for (Stream& stream : run.trials.front().streams) {
      const std::size_t length = static_cast<std::size_t>(stream.values.size()) * sizeof(double);
      std::memcpy(stream.values.data(), bytes[i].data() + from, length);
      from += length;
    }
    out.effects.push_back(names[i]);
    out.runs.push_back(std::move(run));
  }
  return out;
}

}  // namespace jaculus::testbed
