#include "solver/row_words.h"

#include <string_view>

namespace jaculus::solver {
namespace {

/// How the rows of a kind are named, before or behind the name of what they are of.
struct Kind {
  std::string_view text;
  bool before;  ///< "friction of front_foot"; else "front_a voltage"
  std::string_view kind;
};

constexpr Kind kKinds[] = {{"defect of ", true, "equations of motion"},
                           {"friction of ", true, "friction"},
                           {" friction forward", false, "friction"},
                           {" friction backward", false, "friction"},
                           {" voltage where a sample begins", false, "motor voltage"},
                           {" voltage where a sample ends", false, "motor voltage"},
                           {" voltage", false, "motor voltage"},
                           {" torque", false, "motor torque"},
                           {" speed", false, "motor speed"},
                           {" normal force", false, "normal force"},
                           {" range", false, "joint range"},
                           {"jump of the rate of ", true, "impact"},
                           {"continuity of ", true, "impact"}};

/// What the rows where a foot lands are named after, before the phase.
constexpr std::string_view kImpact = "impact at the start of ";

}  // namespace

RowWords row_words(const std::string& name) {
  RowWords words;
  words.what = name;
  const std::size_t colon = name.find(": "), comma = name.find(", ");
  if (colon != std::string::npos && comma < colon) {
    words.phase = name.substr(0, comma);
    words.place = name.substr(comma + 2, colon - comma - 2);
    words.what = name.substr(colon + 2);
  }

  if (name.starts_with(kImpact) && colon != std::string::npos) {
    words.phase = name.substr(kImpact.size(), colon - kImpact.size());
    words.place = "its start";
    words.what = name.substr(colon + 2);
  }

  words.kind = words.what;
  for (const Kind& kind : kKinds) {
    if (kind.before ? !words.what.starts_with(kind.text) : !words.what.ends_with(kind.text))
      continue;
    const std::size_t left = words.what.size() - kind.text.size();
    words.kind = kind.kind;
    words.of = kind.before ? words.what.substr(kind.text.size()) : words.what.substr(0, left);
    break;
  }
  return words;
}

}  // namespace jaculus::solver
