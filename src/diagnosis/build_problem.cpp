#include "diagnosis/build_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/forward/prediction_memory.h"
#include "diagnosis/noise/contradictions.h"
#include "diagnosis/noise/one_off.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kAllWindows = 1'000'000;  // of a trial

using effects::Effect;

/// Channels without any scatter: they were computed, not measured, or a sensor froze.
std::vector<ChannelPlace> silent_channels(const Problem& problem, const NoiseModel& noise,
                                          std::vector<std::string>& notes) {
  std::vector<ChannelPlace> silent;
  for (int d = 0; d < count_of(noise.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    for (int c = 0; c < count_of(observed.channels); ++c) {
      double size = 0.0;
      for (const Segment& segment : observed.segments)
        if (segment.value[c].size() > 0)
          size = std::max(size, segment.value[c].cwiseAbs().maxCoeff());
      const double floor = noise.datasets[d].channels[c].noise_floor;
      if (floor > problem.settings.no_scatter * size && floor > 0.0) continue;

      notes.push_back(fmt::format("{} has no scatter at all, so it is no measurement: left out",
                                  observed.channels[c].name));
      silent.push_back({d, c});
    }
  }
  return silent;
}

std::string note_of(const OneOff& one) {
  return fmt::format(
      "{} left the other trials at {:.3f} s (most in {}, {:.1f} times their scatter): a one-off "
      "disturbance, its data from there on are cut out, not explained",
      one.trial, one.onset, one.channel, one.excess);
}

/// Stamps of all streams that lie on one side of the commands: as a late start would have it, but
/// also clocks that were set so.
void note_late_stamps(const Problem& problem, const NoiseModel& noise,
                      std::vector<std::string>& notes) {
  for (int d = 0; d < count_of(noise.alignments); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    if (observed.measured_input) continue;
    const std::vector<SegmentAlignment>& segments = noise.alignments[d].segments;
    double least = kInfinity, most = -kInfinity;
    for (int s = 0; s < count_of(observed.streams); ++s) {
      double mean = 0.0;
      for (const SegmentAlignment& segment : segments)
        mean += segment.shift[s] / static_cast<double>(segments.size());
      least = std::min(least, mean);
      most = std::max(most, mean);
    }

    const double noted = problem.settings.late_stamps_noted;
    if (least < noted && most > -noted) continue;
    notes.push_back(fmt::format(
        "the motion comes {:.1f} ms {} than the stamps say, in every stream: clocks, a late start "
        "and a "
        "common latency of the sensors look alike, so it is aligned and not counted as a gap",
        1e3 * std::abs(0.5 * (least + most)), least > 0.0 ? "later" : "sooner"));
  }
}

std::vector<model::PlanarModel> robots_of(const std::vector<trajectory::Dataset>& datasets) {
  std::vector<model::PlanarModel> models;
  for (const trajectory::Dataset& dataset : datasets)
    models.push_back(simulation::dataset_robot(dataset).planar);
  return models;
}

/// Whether a segment has enough samples of some channel to be worth keeping.
bool has_samples(const Segment& segment, int fewest) {
  return std::any_of(segment.time.begin(), segment.time.end(),
                     [fewest](const Vector& time) { return time.size() >= fewest; });
}

/// The observations up to where the model as stated can't be simulated any further, less what is
/// simulated beyond the last row: a wrong model may well break down.
Observations until_breakdown(const Problem& problem, std::vector<std::string>& notes) {
  const Settings& settings = problem.settings;
  const Vector nominal = problem.hypotheses.nominal();
  Observations kept = problem.observations;
  std::vector<SegmentTail> tails;

  for (int d = 0; d < count_of(kept.datasets); ++d) {
    ObservedDataset& observed = kept.datasets[d];
    const bool each = observed.measured_input;  // has a simulation
    for (int s = 0; s < (each ? count_of(observed.segments) : 1); ++s) {
      const Prediction prediction = problem.forward(d, s, nominal);
      if (prediction.valid || std::isnan(prediction.reached)) continue;

      const double end = prediction.reached - settings.simulated_beyond - settings.grid;
      for (int own = 0; own < count_of(observed.segments); ++own)
        if (!each || own == s) tails.push_back({d, own, observed.segments[own].start + end});
      if (!each) observed.window_end = end;
      notes.push_back(
          fmt::format("{}: the model as stated can't be simulated to the end ({}), so data from "
                      "{:.3f} s on are "
                      "left out",
                      observed.name(), prediction.message, observed.segments[s].start + end));
    }
  }

  kept = without_tails(std::move(kept), tails);
  for (ObservedDataset& observed : kept.datasets)
    std::erase_if(observed.segments,
                  [&](const Segment& s) { return !has_samples(s, settings.fewest_samples); });
  std::erase_if(kept.datasets, [](const ObservedDataset& d) { return d.segments.empty(); });
  return kept;
}

std::vector<SegmentTail> tails_of(const std::vector<OneOff>& disturbances) {
  std::vector<SegmentTail> tails;
  for (const OneOff& one : disturbances) tails.push_back({one.dataset, one.segment, one.onset});
  return tails;
}

}  // namespace

ProblemBuilder builder_of(std::vector<Effect> effects, const Settings& settings) {
  return [kept = std::move(effects), settings](Observations observations) {
    std::vector<const Effect*> list;
    for (const Effect& effect : kept) list.push_back(&effect);
    PlantForward forward = plant_forward(observations, list, settings);
    forward.predict =
        remembering(std::move(forward.predict), forward.hypotheses.nominal(), settings.remembered);
    return BuiltProblem{
        std::make_shared<const Problem>(Problem{std::move(observations), forward.hypotheses,
                                                forward.predict, settings, forward.tolerance_part}),
        forward};
  };
}

ProblemBuilder builder_of(const DiagnoseOptions& options) {
  std::vector<Effect> effects;
  for (const Effect* effect : options.effects) effects.push_back(*effect);
  if (effects.empty())
    effects = options.catalogue ? *options.catalogue : effects::effect_catalogue();
  return builder_of(std::move(effects), options.settings);
}

ProblemBuilder builder_like(const Problem& problem) {
  return [problem](Observations observations) {
    Problem changed = problem;
    changed.observations = std::move(observations);
    return BuiltProblem{std::make_shared<const Problem>(std::move(changed)), {}};
  };
}

BuiltProblem build_problem(const std::vector<trajectory::Dataset>& datasets,
                           const DiagnoseOptions& options) {
  Observations observations = observe(datasets, robots_of(datasets), options.settings);
  if (!observations.datasets.empty() && observations.insufficient.empty())
    return builder_of(options)(std::move(observations));
  return {std::make_shared<const Problem>(
              Problem{std::move(observations), {}, {}, options.settings, {}}),
          {}};
}

BuiltProblem in_boxes(const std::vector<trajectory::Dataset>& datasets, DiagnoseOptions options,
                      double box) {
  options.settings.windows = kAllWindows;
  options.settings.window_length = box;
  options.settings.window_start_half_width = 0.5 * box;
  return build_problem(datasets, options);
}

Prepared prepare(BuiltProblem built, const ProblemBuilder& rebuild) {
  Prepared out{std::move(built), {}, {}, {}, {}};
  // Of the problem as it stands then: one of fewer data may have other parameters.
  const auto about_nominal = [&out](const std::vector<Alignment>& from) {
    const Problem& problem = *out.built.problem;
    out.noise = estimate_noise(problem, problem.hypotheses.nominal(), from);
  };
  about_nominal({});
  if (!out.noise.valid()) {
    Observations kept = until_breakdown(*out.built.problem, out.notes);
    if (!kept.datasets.empty()) {
      out.built = rebuild(std::move(kept));
      about_nominal({});
    }
  }
  if (!out.noise.valid()) {
    out.reasons.push_back("the nominal model can't be simulated through this experiment: " +
                          out.noise.at_p.message);
    return out;
  }
  out.reasons = contradictions(*out.built.problem, out.noise);
  if (auto inverted = with_inputs_inverted(out.built.problem->observations)) {
    const std::string reason =
        inverted_inputs(*out.built.problem, out.noise, *rebuild(std::move(*inverted)).problem);
    if (!reason.empty()) out.reasons.push_back(reason);
  }
  if (!out.reasons.empty()) return out;

  const auto silent = silent_channels(*out.built.problem, out.noise, out.notes);
  out.disturbances = one_off_disturbances(*out.built.problem, out.noise, silent);
  for (const OneOff& one : out.disturbances) out.notes.push_back(note_of(one));
  if (!silent.empty() || !out.disturbances.empty()) {
    const std::size_t before = out.built.problem->observations.datasets.size();
    Observations kept = without_channels(
        without_tails(out.built.problem->observations, tails_of(out.disturbances)), silent);
    if (kept.datasets.empty()) {
      out.reasons.emplace_back("no channel has any scatter, so nothing tells the noise");
      return out;
    }
    const bool same = kept.datasets.size() == before;
    out.built = rebuild(std::move(kept));
    about_nominal(same ? std::vector<Alignment>(out.noise.alignments) : std::vector<Alignment>{});
  }
  note_late_stamps(*out.built.problem, out.noise, out.notes);
  return out;
}

Comparison first_comparison(const Problem& problem, NoiseModel noise) {
  Comparison comparison = comparison_about(problem, with_random_effects(problem, std::move(noise)));
  const std::vector<int>& gains = problem.hypotheses.gains;
  if (gains.empty()) return comparison;

  for (int round = 0; round < 2; ++round) {
    FitOptions options;
    options.rounds = 1;  // what noise is about needs no more
    const Fit none = fit_model(problem, comparison.whitening, gains,
                               problem.hypotheses.gain_starts(comparison.noise.p), options);
    if (!none.valid) break;
    NoiseModel again = estimate_noise(problem, none.p, comparison.noise.alignments);
    if (!again.valid()) break;
    comparison = comparison_about(problem, with_random_effects(problem, std::move(again)));
  }
  return comparison;
}

Fit fit_members_by_slopes(const Problem& problem, const Whitening& whitening,
                          const LinearNuisances& linear, const std::vector<int>& members) {
  FitOptions options;
  options.by_slopes = &linear;
  Fit model = fit_model(problem, whitening, problem.hypotheses.nuisances(), {linear.p}, options);
  for (int k = 0; k < count_of(members) && model.valid; ++k) {
    const Standing standing = standing_of(problem, whitening, model);
    const Probe probe =
        probe_candidate(problem, whitening, model, standing, members[k], Screening::line_search);
    const std::vector<int> joined(members.begin(), members.begin() + k + 1);
    model = fit_model(problem, whitening, problem.hypotheses.freed_by(joined),
                      fit_starts(problem, model.p, members[k], probe), options);
    if (k == 0) model = fit_around(problem, whitening, model, options);
  }
  return model;
}

Fit fit_members(const Problem& problem, const Whitening& whitening, const Vector& p,
                const std::vector<int>& members) {
  const LinearNuisances linear = linear_nuisances(problem, whitening, p);
  Fit model = fit_members_by_slopes(problem, whitening, linear, members);
  if (!model.valid || linear.slopes.cols() == 0) return model;
  return fit_model(problem, whitening, model.free, {model.p, model.simulated});
}

}  // namespace jaculus::diagnosis
