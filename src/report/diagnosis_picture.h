#pragma once
// The robot at telling times of a diagnosis: measured and predicted over one another, with the
// forces that the nominal model lacks.

#include "jaculus/diagnosis/diagnosis.h"
#include "report/document/document.h"

namespace jaculus::report {

/// A panel a posture (diagnosis.where->postures), each about the measured base. Without panels
/// where there are none.
Picture telling_picture(const diagnosis::Diagnosis& diagnosis);

}  // namespace jaculus::report
