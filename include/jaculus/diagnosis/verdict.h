#pragma once
// The verdicts of a diagnosis.

#include <string>

namespace jaculus::diagnosis {

enum class Verdict {
  insufficient,  ///< the data can't answer; the reasons say why
  none,          ///< no gap beyond what noise and the nominal model's own faults make
  unexplained,   ///< a gap, and nothing in the catalogue that explains it
  effect,        ///< one effect
  several,       ///< several effects together
  partial,       ///< effects that are established, and something else
  ambiguous      ///< these effects, which the data can't tell apart
};

/// "insufficient", "none", ...
const char* to_text(Verdict verdict);
/// Of its text. InputError, opening with `place`, where it is none of them.
Verdict verdict_from(const std::string& text, const std::string& place);

/// Whether a verdict names effects.
inline bool names_effects(Verdict verdict) {
  return verdict == Verdict::effect || verdict == Verdict::several || verdict == Verdict::partial ||
         verdict == Verdict::ambiguous;
}

}  // namespace jaculus::diagnosis
