#include "jaculus/diagnosis/localise.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diagnosis/localise_departure.h"
#include "diagnosis/localise_force.h"
#include "diagnosis/localise_rows.h"
#include "diagnosis/localise_signatures.h"
#include "diagnosis/localise_windows.h"

namespace jaculus {
namespace {

const Channel& channel_of(const ConditionRows& rows, const RowSpan& span) {
  return rows.condition->channels[static_cast<size_t>(span.channel)];
}

/// Gap by channel over all conditions; conditions with other noise floors count by their own.
std::vector<ChannelGap> channel_gaps(const std::vector<ConditionRows>& conditions) {
  std::vector<ChannelGap> gaps;
  std::vector<double> squares, noise, multiples;
  for (const ConditionRows& rows : conditions) {
    for (const RowSpan& span : rows.spans) {
      const Channel& channel = channel_of(rows, span);
      const auto same = std::find_if(gaps.begin(), gaps.end(), [&](const ChannelGap& g) {
        return g.stream == channel.stream && g.name == channel.name;
      });
      const auto at = static_cast<size_t>(same - gaps.begin());
      if (same == gaps.end()) {
        gaps.push_back({channel.stream, channel.name, channel.unit});
        squares.push_back(0.0);
        noise.push_back(0.0);
        multiples.push_back(0.0);
      }
      const double energy = rows.judged.segment(span.first, span.count).squaredNorm();
      const double floor = channel.noise_floor * channel.noise_floor;
      squares[at] += energy;
      noise[at] += floor * span.count;
      multiples[at] += floor > 0.0 ? energy / floor : 0.0;
      gaps[at].samples += span.count;
      gaps[at].effective += span.count / channel_inflation(channel);
    }
  }
  for (size_t i = 0; i < gaps.size(); ++i) {
    gaps[i].gap = std::sqrt(squares[i] / gaps[i].samples);
    gaps[i].noise_floor = std::sqrt(noise[i] / gaps[i].samples);
    gaps[i].multiple = std::sqrt(multiples[i] / gaps[i].samples);
  }
  return gaps;
}

/// Mean residual of a channel over the runs of a condition, in bins of its spacing on the command's clock.
DepartureChannel mean_residual(const ConditionRows& rows, int c) {
  const Channel& channel = rows.condition->channels[static_cast<size_t>(c)];
  struct Bin {
    double residual = 0.0, time = 0.0, deviation = 0.0;
    int count = 0;
  };
  std::map<long, Bin> bins;
  const auto stream = static_cast<size_t>(rows.condition->stream_index(channel.stream));
  for (const RowSpan& span : rows.spans) {
    if (span.channel != c) continue;
    const Run& run = rows.condition->runs[static_cast<size_t>(span.run)];
    for (int k = 0; k < span.count; ++k) {
      const double time = run.time[static_cast<size_t>(c)][k] - run.start - run.shift[stream];
      Bin& bin = bins[std::lround(time / channel.spacing)];
      bin.residual += rows.judged[span.first + k];
      bin.time += time;
      bin.deviation += std::pow(rows.judged_deviation[span.first + k], 2);
      ++bin.count;
    }
  }
  DepartureChannel mean;
  mean.name = channel.name;
  mean.rate = channel.name.ends_with("_velocity") || channel.held;
  mean.inflation = channel_inflation(channel);
  mean.time.resize(static_cast<Eigen::Index>(bins.size()));
  mean.mean.resize(mean.time.size());
  mean.error.resize(mean.time.size());
  Eigen::Index i = 0;
  for (const auto& [key, bin] : bins) {
    mean.time[i] = bin.time / bin.count;
    mean.mean[i] = bin.residual / bin.count;
    mean.error[i] = std::sqrt((channel.noise_floor * channel.noise_floor + bin.deviation / bin.count) / bin.count);
    ++i;
  }
  return mean;
}

/// The earliest departure among the conditions that a plan or script drove.
Departure departure_of(const std::vector<ConditionRows>& conditions, std::vector<std::string>& notes) {
  Departure first;
  for (const ConditionRows& rows : conditions) {
    if (rows.condition->measured_input) {
      notes.push_back("a logged input drove the joint, so the model restarts all along: no first departure");
      continue;
    }
    std::vector<DepartureChannel> channels;
    for (size_t c = 0; c < rows.condition->channels.size(); ++c)
      if (rows.condition->channels[c].noise_floor > 0.0) channels.push_back(mean_residual(rows, static_cast<int>(c)));
    Departure d = first_departure(channels, 0.05, rows.condition->window_end);
    if (!first.found || (d.found && d.time < first.time)) first = std::move(d);
  }
  return first;
}

/// Windows, phases and force residual of the first condition that a plan or script drove.
void add_windows(const DiagnosisProblem& problem, const std::vector<ConditionRows>& conditions,
                 const PlantForward& forward, const Vector& p, const LocaliseOptions& options, Localisation& where) {
  for (const ConditionRows& rows : conditions) {
    if (rows.condition->measured_input) continue;
    std::vector<DepartureChannel> means;
    for (size_t c = 0; c < rows.condition->channels.size(); ++c)
      means.push_back(mean_residual(rows, static_cast<int>(c)));
    WindowAnswer answer = restarted_windows(rows, means, forward, p, options.windows, options.seed);
    where.windows = std::move(answer.windows);
    where.phases = std::move(answer.phases);
    ForceAnswer force = force_residual(problem, rows, means, forward, p, options.seed);
    where.force = std::move(force.residual);
    where.force_components = std::move(force.components);
    if (conditions.size() > 1)
      where.notes.push_back("windows, phases and missing force are those of the first dataset");
    return;
  }
}

std::string names_of(const std::vector<Component>& components) {
  std::vector<std::string> names;
  for (const Component c : components) names.emplace_back(component_name(c));
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Whether no channel of any condition but the base's motion was measured, on a robot that has motors.
bool motion_capture_alone(const std::vector<ConditionRows>& conditions) {
  for (const ConditionRows& rows : conditions) {
    if (rows.condition->model.motors.empty()) return false;
    for (const Channel& channel : rows.condition->channels)
      if (channel.name != "x" && channel.name != "z" && channel.name != "pitch") return false;
  }
  return true;
}

/// What is lost with joints unmeasured: of the measured gap, which components' signatures pass for another's.
void note_motion_capture(const Localisation& where, std::vector<std::string>& notes) {
  int alike = 0, visible = 0;
  for (const ComponentShare& c : where.components) {
    visible += c.visible ? 1 : 0;
    alike += c.visible && !c.like.empty() ? 1 : 0;
  }
  notes.push_back(
      fmt::format("motion capture alone: joints are inferred from feet that are taken to stand still, and {} of {} "
                  "visible components could pass for another; record joint angles to tell more",
                  alike, visible));
}

/// What these channels can't tell about components.
void note_components(const Localisation& where, const ShareAnswer& answer, std::vector<std::string>& notes) {
  std::vector<Component> blind;
  for (const ComponentShare& c : where.components) {
    if (!c.visible) blind.push_back(c.component);
    if (c.share >= 0.1 && !c.like.empty())
      notes.push_back(fmt::format("{} could be {} just as well: these channels don't tell them apart at this gap",
                                  component_name(c.component), names_of(c.like)));
  }
  if (!blind.empty()) notes.push_back(fmt::format("nothing of {} would show in these channels", names_of(blind)));
  if (answer.kappa > 2.0)
    notes.push_back(fmt::format(
        "no effect, nor three together, fits to the noise: intervals count what is left as {:.1f} times the noise",
        std::sqrt(answer.kappa)));
}

}  // namespace

Localisation localise(const DiagnosisProblem& problem, const Linearisation& about, const PlantForward& forward,
                      const LocaliseOptions& options) {
  Localisation where;
  if (!about.at_p.valid) {
    where.notes.push_back("the model can't be simulated through this experiment: " + about.at_p.message);
    return where;
  }
  std::vector<ConditionRows> conditions;
  for (size_t c = 0; c < problem.observations.conditions.size(); ++c)
    conditions.push_back(condition_rows(problem, about, static_cast<int>(c)));
  where.channels = channel_gaps(conditions);
  double squares = 0.0, samples = 0.0;
  for (const ChannelGap& g : where.channels) {
    if (!(g.noise_floor > 0.0)) where.notes.push_back(g.name + " has no scatter, so it has no part in what follows");
    squares += g.multiple * g.multiple * g.samples;
    samples += g.noise_floor > 0.0 ? g.samples : 0;
  }
  where.strength = samples > 0.0 ? std::sqrt(squares / samples) : 0.0;
  if (samples == 0.0) return where;
  where.departure = departure_of(conditions, where.notes);
  add_windows(problem, conditions, forward, about.p, options, where);
  const Signatures signatures = signatures_of(problem, about, forward, where.notes);
  ShareOptions sharing;
  sharing.seed = options.seed;
  const ShareAnswer answer = component_shares(signatures.system, signatures.candidates, sharing);
  where.components = answer.components;
  where.unexplained = answer.unexplained;
  note_components(where, answer, where.notes);
  if (motion_capture_alone(conditions)) note_motion_capture(where, where.notes);
  return where;
}

}  // namespace jaculus
