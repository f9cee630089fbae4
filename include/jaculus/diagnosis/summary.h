#pragma once
// What a diagnosis says, in three plain sentences.

#include <string>
#include <vector>

#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

struct Summary {
  std::string where;    ///< where the gap lies
  std::string which;    ///< which effect causes it
  std::string how_far;  ///< how far it shrinks on held-out data, in units; whether that is enough
};
Summary summary_of(const Diagnosis& diagnosis);

/// Where forces are missing and what they follow, a sentence a place; one without a pattern is
/// told of verdicts by which something is left.
std::vector<std::string> remainder_sentences(const Diagnosis& diagnosis);

/// The first of these of a place where something is left that follows something; else empty.
std::string leading_remainder(const Diagnosis& diagnosis);

/// A name as words: "front_a" is "front a".
std::string in_words(std::string name);

}  // namespace jaculus::diagnosis
