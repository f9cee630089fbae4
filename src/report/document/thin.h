#pragma once
// Reports that would grow too large.

#include "report/document/document.h"

namespace jaculus::report {

/// The document with at most about `most` points a series: of each stretch of x its least and its
/// largest value stay, so that no peak is lost. A notice says so.
Document thinned(const Document& document, std::size_t most);

}  // namespace jaculus::report
