// Which effects the robot itself can't tell from the true one on a case's streams, however long one
// looks.
//
// A rival is equivalent where some strength of it, with the streams' clocks free, shows what the
// true effect shows to within
//   1/2 trials |rest|^2 < 3,
// |rest| being the difference of two noise-free runs over the noise: even a diagnosis by an exact
// model of this robot would then gain a log Bayes factor under 3 by knowing which it was. Strength
// and clocks are sought by Gauss-Newton from what the signatures say; the strength's columns follow
// by Broyden's update, so that a step costs one run.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "testbed/draws.h"
#include "testbed/noise_floor.h"

namespace jaculus::testbed {
namespace {

constexpr double kSame = 3.0;  ///< log Bayes factor under which two effects are one
/// share of the difference that a rival's signature may leave to be run
constexpr double kAlike = 0.5;
constexpr int kMostRivals = 6;       ///< that are run, nearest signatures first
constexpr int kSteps = 8;            ///< Gauss-Newton steps
constexpr double kStep = 0.003;      ///< of a parameter's range, for its column
constexpr double kHopeless = 300.0;  ///< of kSame, left after two steps: given up
constexpr double kDutyStep = 0.004;  ///< to which a driver resolves its duty, 8 bit [-]
constexpr double kBegin = 0.01;      ///< s, of electric channels not heeded
constexpr double kClock = 1e-4;      ///< s, by which clocks are moved for their columns

/// What the streams of a case show of a run at fine rates, every stream's clock late by `late` [s],
/// over `floor`.
Vector seen(const trajectory::Dataset& fine, const trajectory::Dataset& like, const Vector& late,
            const Vector& floor) {
  std::vector<double> out;
  const auto& streams = like.trials.front().streams;

  for (int s = 0; s < count_of(streams); ++s) {
    const trajectory::Stream& from = *fine.trials.front().stream(streams[s].name);
    const auto last = static_cast<double>(from.values.cols() - 1);
    for (const std::string& channel : streams[s].channels) {
      const int row = from.channel(channel);
      for (const double t : streams[s].time) {
        const double at = std::clamp((t - streams[s].time[0] - late[s]) * from.rate_hz, 0.0, last);
        const auto k = std::min<Eigen::Index>(std::lround(std::floor(at)), from.values.cols() - 2);
        const double part = at - static_cast<double>(k);
        out.push_back(
            row < 0 ? 0.0 : (1.0 - part) * from.values(row, k) + part * from.values(row, k + 1));
      }
    }
  }

  const Vector values = Eigen::Map<Vector>(out.data(), out.size());
  return floor.size() == 0 ? values : Vector(values.cwiseQuotient(floor));
}

/// Of motion as of a gap; of electric channels what the sensor adds, infinite where they are not
/// `heeded`.
double noise_of(const std::string& channel, const std::string& unit, const SensorSpec& sensors,
                const RobotFiles& robot, bool heeded) {
  const double of_motion = channel_floor(channel, unit, sensors, robot);
  if (!std::isnan(of_motion)) return of_motion;
  const trajectory::Quantity quantity = trajectory::parse_channel(channel).quantity;
  if (!heeded || quantity == trajectory::Quantity::apart) return kInfinity;
  if (quantity == trajectory::Quantity::duty) return kDutyStep;
  return unit == "V" ? sensors.voltmeter : sensors.ammeter;
}

/// Noise of every value of `seen`; beside a jump, where a sample tells a time, at least half of
/// what the run bends there. Electric channels say nothing of the moment in which the commands
/// begin: what a late stamp shows there is from before the log.
Vector floors(const trajectory::Dataset& fine, const trajectory::Dataset& like,
              const SensorSpec& sensors, const RobotFiles& robot, bool electric) {
  const auto& streams = like.trials.front().streams;
  const Vector values = seen(fine, like, Vector::Zero(streams.size()), {});

  Vector out(values.size());
  Eigen::Index at = 0;
  for (const trajectory::Stream& stream : streams) {
    for (std::size_t c = 0; c < stream.channels.size(); ++c) {
      const Eigen::Index n = stream.time.size();
      const Vector most = bends(values.segment(at, n));
      const double noise = noise_of(stream.channels[c], stream.units[c], sensors, robot, electric);
      const bool of_motion =
          !std::isnan(channel_floor(stream.channels[c], stream.units[c], sensors, robot));
      for (Eigen::Index k = 0; k < n; ++k) {
        const bool begins = !of_motion && stream.time[k] - stream.time[0] < kBegin;
        out[at + k] = begins ? kInfinity : std::hypot(noise, 0.5 * most[k]);
      }
      at += n;
    }
  }

  return out;
}

/// Columns of the streams' clocks, one a stream [1/s].
Matrix clock_columns(const trajectory::Dataset& fine, const trajectory::Dataset& like,
                     const Vector& late, const Vector& floor) {
  Matrix out(floor.size(), late.size());
  for (Eigen::Index s = 0; s < late.size(); ++s) {
    Vector later = late, sooner = late;
    later[s] += kClock;
    sooner[s] -= kClock;
    out.col(s) =
        (seen(fine, like, later, floor) - seen(fine, like, sooner, floor)) / (2.0 * kClock);
  }
  return out;
}

/// Least log Bayes factor of `trials` trials that a shift of the clocks alone leaves of `truth`
/// beside `nominal`.
double clocks_alone(const trajectory::Dataset& nominal, const trajectory::Dataset& truth,
                    const trajectory::Dataset& like, const Vector& floor, int trials) {
  Vector late = Vector::Zero(like.trials.front().streams.size());
  const Vector target = seen(truth, like, late, floor);
  double least = kInfinity;
  for (int k = 0; k < kSteps; ++k) {
    const Vector rest = target - seen(nominal, like, late, floor);
    least = std::min(least, 0.5 * trials * rest.squaredNorm());
    late += clock_columns(nominal, like, late, floor).colPivHouseholderQr().solve(rest);
  }
  return least;
}

/// How near an effect's signature comes to a difference, at the strength that comes nearest.
struct Likeness {
  std::string effect;
  double strength = 0.0;  ///< of its first parameter
  double rest = 0.0;      ///< share of the difference that is left, clocks free [0, 1]
};

/// Effects whose signatures resemble what `truth` has beyond the nominal run; nearest first.
std::vector<Likeness> likenesses(const Stage& stage, const Signatures& signatures,
                                 const trajectory::Dataset& like, const trajectory::Dataset& truth,
                                 const Vector& floor) {
  const Vector on_time = Vector::Zero(like.trials.front().streams.size());
  const Vector nominal = seen(signatures.nominal, like, on_time, floor);
  const Vector difference = seen(truth, like, on_time, floor) - nominal;
  Matrix directions(difference.size(), 2 * on_time.size() + 1);
  directions.leftCols(on_time.size()) = clock_columns(signatures.nominal, like, on_time, floor);
  directions.middleCols(on_time.size(), on_time.size()) =
      clock_columns(truth, like, on_time, floor);

  std::vector<Likeness> found;
  for (std::size_t i = 0; i < signatures.effects.size(); ++i) {
    const std::string& name = signatures.effects[i];
    directions.rightCols(1) = seen(signatures.runs[i], like, on_time, floor) - nominal;
    const Vector solution = directions.colPivHouseholderQr().solve(difference);
    const double rest =
        (difference - directions * solution).norm() / std::max(difference.norm(), 1e-12);
    const BenchEffect& effect = *find_bench_effect(stage.effects, name);
    const double usual = effect.parameters.front().usual;
    if (rest < kAlike)
      found.push_back(
          {name, usual + solution.tail<1>()[0] * (signature_strength(effect) - usual), rest});
  }

  std::sort(found.begin(), found.end(),
            [](const Likeness& a, const Likeness& b) { return a.rest < b.rest; });
  return found;
}

/// One rival's search.
class Rival {
 public:
  Rival(const BenchEffect& effect, const Stage& stage, const trajectory::Dataset& like,
        const trajectory::Dataset& truth, const Vector& floor)
      : effect_(effect), stage_(stage), like_(like), floor_(floor), theta_(usual_values(effect)) {
    late_ = Vector::Zero(like.trials.front().streams.size());
    target_ = seen(truth, like, late_, floor);
  }

  /// Least log Bayes factor of `trials` trials found, from the strength `first` on.
  double search(double first, int trials) {
    theta_[0] = std::clamp(first, effect_.parameters[0].lower, effect_.parameters[0].upper);
    std::optional<trajectory::Dataset> run = run_at(theta_);
    if (!run) return kInfinity;
    Matrix of_theta = columns(*run);
    const auto evidence = [&](const Vector& rest) { return 0.5 * trials * rest.squaredNorm(); };
    Vector rest = target_ - seen(*run, like_, late_, floor_);
    for (int k = 0; k < kSteps && evidence(rest) >= kSame; ++k) {
      if (k == 2 && evidence(rest) > kHopeless * kSame) break;
      if (!step(*run, of_theta, rest)) break;
    }
    return evidence(rest);
  }

 private:
  std::optional<trajectory::Dataset> run_at(const std::vector<double>& theta) const {
    Changes changes;
    effect_.apply(theta, changes);
    return exact_run(stage_, changes, signature_spec());
  }

  [[nodiscard]] double width(std::size_t i) const {
    return effect_.parameters[i].upper - effect_.parameters[i].lower;
  }

  /// Columns of the parameters' shares of their ranges, by one run each.
  Matrix columns(const trajectory::Dataset& run) const {
    Matrix out = Matrix::Zero(target_.size(), theta_.size());
    const Vector here = seen(run, like_, late_, floor_);
    for (int i = 0; i < count_of(theta_); ++i) {
      if (width(i) <= 0.0) continue;
      std::vector<double> moved = theta_;
      const double up = effect_.parameters[i].upper - theta_[i];
      moved[i] += (up > kStep * width(i) ? kStep : -kStep) * width(i);
      const std::optional<trajectory::Dataset> other = run_at(moved);
      if (!other) continue;
      out.col(i) =
          (seen(*other, like_, late_, floor_) - here) / ((moved[i] - theta_[i]) / width(i));
    }
    return out;
  }

  /// One step, halved up to twice until it betters; false where it doesn't.
  bool step(trajectory::Dataset& run, Matrix& of_theta, Vector& rest) {
    Matrix all(rest.size(), of_theta.cols() + late_.size());
    all.leftCols(of_theta.cols()) = of_theta;
    all.rightCols(late_.size()) = clock_columns(run, like_, late_, floor_);
    Vector scale = all.colwise().norm().cwiseMax(1e-12);
    Vector move = (all * scale.cwiseInverse().asDiagonal())
                      .colPivHouseholderQr()
                      .solve(rest)
                      .cwiseQuotient(scale);

    for (int halving = 0; halving < 3; ++halving, move *= 0.5) {
      std::vector<double> theta = theta_;
      Vector shares = Vector::Zero(of_theta.cols());
      for (int i = 0; i < count_of(theta); ++i) {
        if (width(i) <= 0.0) continue;
        const BenchParameter& p = effect_.parameters[i];
        theta[i] = std::clamp(theta[i] + move[i] * width(i), p.lower, p.upper);
        shares[i] = (theta[i] - theta_[i]) / width(i);
      }
      const Vector late = late_ + move.tail(late_.size());
      const std::optional<trajectory::Dataset> next = run_at(theta);
      if (!next) continue;
      const Vector left = target_ - seen(*next, like_, late, floor_);
      if (shares.squaredNorm() > 0.0) {
        const Vector was = seen(*next, like_, late_, floor_) - seen(run, like_, late_, floor_);
        of_theta += (was - of_theta * shares) * shares.transpose() / shares.squaredNorm();
      }
      if (left.squaredNorm() >= rest.squaredNorm()) continue;
      const bool worth = left.squaredNorm() < 0.98 * rest.squaredNorm();
      theta_ = theta;
      late_ = late;
      run = *next;
      rest = left;
      return worth;
    }

    return false;
  }

  const BenchEffect& effect_;
  const Stage& stage_;
  const trajectory::Dataset& like_;
  const Vector& floor_;
  Vector target_, late_;
  std::vector<double> theta_;
};

}  // namespace

std::vector<std::string> equivalents(const Stage& stage, const Signatures& signatures,
                                     const TrialSpec& spec, const trajectory::Dataset& like,
                                     const Dose& truth) {
  Changes changes;
  truth.effect->apply(truth.values, changes);
  const std::optional<trajectory::Dataset> run = exact_run(stage, changes, signature_spec());
  std::vector<std::string> found;
  if (!run || signatures.effects.empty()) return found;
  const Vector floor = floors(*run, like, spec.sensors, stage.robot, true);

  // no effect shows at all
  if (clocks_alone(signatures.nominal, *run, like, floor, spec.trials) < kSame) return found;
  int tried = 0;
  for (const Likeness& near : likenesses(stage, signatures, like, *run,
                                         floors(*run, like, spec.sensors, stage.robot, false))) {
    if (near.effect == truth.effect->name || ++tried > kMostRivals) continue;
    const BenchEffect& effect = *find_bench_effect(stage.effects, near.effect);
    std::vector<double> starts = {near.strength};
    if (effect.parameters.front().unit == truth.effect->parameters.front().unit)
      starts.push_back(truth.values[0]);
    const bool same = std::any_of(starts.begin(), starts.end(), [&](double strength) {
      return Rival(effect, stage, like, *run, floor).search(strength, spec.trials) < kSame;
    });
    if (same) found.push_back(near.effect);
  }

  return found;
}

}  // namespace jaculus::testbed
