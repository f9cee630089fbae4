#pragma once
// A constraint as a program of its own would add it: declared here alone, known to no other file.

#include "jaculus/transcription/term.h"

namespace jaculus::test {

/// The square of the pitch rate at one collocation point, at most limit^2.
inline transcription::PathTerm squared_pitch_rate(int pitch, double limit) {
  transcription::PathTerm term;
  term.name = "squared pitch rate";
  term.rows.push_back({term.name, "rad^2/s^2", {-kInfinity, limit * limit}, limit * limit});
  term.reads.velocity = true;

  term.evaluate = [pitch](const transcription::PointView& view, VectorRef values, Matrix* J,
                          const ConstVectorRef* multipliers, Matrix* H) {
    const int at = view.v_at() + pitch;
    const double rate = view.point.v[pitch];
    values[0] = rate * rate;
    if (J) (*J)(0, at) = 2.0 * rate;
    if (H) (*H)(at, at) += 2.0 * (*multipliers)[0];
  };
  return term;
}

inline void add_pitch_rate(const transcription::TermSpec& spec,
                           transcription::TermContext& context) {
  const double limit = spec.values.number("limit");
  const int pitch = context.model().coordinate_index("pitch");
  for (const int phase : all_named(spec, "phases", context))
    context.path[phase].push_back(squared_pitch_rate(pitch, limit));
}

inline transcription::TermType pitch_rate() {
  namespace key = transcription::key;
  return {.name = "pitch_rate",
          .meaning = "how fast the body may pitch",
          .keys = {{"limit", key::Number{dimension::angular_velocity, {1e-3, 100.0}},
                    "largest rate either way"},
                   {"phases", key::Names{key::Of::phase}, "list of phases", {.words = "all"}}},
          .example = "limit: 300 deg/s, phases: [rear_feet]",
          .make = add_pitch_rate};
}

/// The library's terms and this one.
inline transcription::TermCatalogue catalogue_with_own_term() {
  transcription::TermCatalogue catalogue = transcription::term_catalogue();
  catalogue.push_back(pitch_rate());
  return catalogue;
}

}  // namespace jaculus::test
