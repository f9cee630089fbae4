#pragma once
// Parts of the reports of plans.

#include <string>
#include <vector>

#include "jaculus/report/plan_report.h"
#include "report/document/document.h"

namespace jaculus::report {

/// What a chart shows of each plan, and its limits.
struct ChannelChart {
  std::string channel;  ///< column of plan.csv
  std::string title;
  /// drawn on both sides of zero, where every plan has the same
  double solver::MotorFigures::*limit = nullptr;
  std::string motor = {};  ///< whose limit it is
  bool held = false;       ///< an input: steps where the plan holds it from sample to sample
};

/// A column of every plan that has it against time; no series where none has.
Chart channel_chart(const std::vector<PlanRecord>& plans, const ChannelChart& what);

Section leap_section(const std::vector<PlanRecord>& plans);
Section motion_section(const std::vector<PlanRecord>& plans);
Section motor_section(const std::vector<PlanRecord>& plans);
Section force_section(const std::vector<PlanRecord>& plans);
Section verification_section(const std::vector<PlanRecord>& plans);
Section history_section(const std::vector<PlanRecord>& plans);

/// Sections that a single plan and several have in common, after what is particular.
void add_common_sections(const std::vector<PlanRecord>& plans, Document& document);

/// What to mind of a plan: that it is no solution, or failed its check.
void add_notices(const solver::Summary& summary, Document& document);

/// A share in per cent.
std::string share_text(double value);

/// The authors' figures beside those of the plans; no rows where there are none.
ReportTable published_table(const std::vector<PlanRecord>& plans);

}  // namespace jaculus::report
