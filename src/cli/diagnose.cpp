// jaculus diagnose: why a robot did something else than its plan.

#include "jaculus/diagnosis/diagnose.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <memory>

#include "cli/reporting.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/diagnosis_report.h"

namespace jaculus::cli {
namespace {

struct DiagnoseOptions {
  Common common;
  std::vector<std::string> datasets;
  std::string settings;                 ///< file
  std::vector<std::string> tolerances;  ///< "x=5mm"
  std::string horizon;                  ///< "0.1 s"; empty: the whole motion
  std::vector<std::string> effect_files;
  bool explain = false;
};

/// Part of the time that lies behind where a stage first begins: rough, from leaps of the plant.
const std::vector<std::pair<std::string, double>> kStages = {{"screening", 0.003},
                                                             {"single effects", 0.01},
                                                             {"pairs of effects", 0.25},
                                                             {"triples of effects", 0.5},
                                                             {"held-out gap and intervals", 0.8},
                                                             {"where the gap lies", 0.9}};

int run_diagnose(const DiagnoseOptions& options) {
  restore_default_interrupts();
  diagnosis::DiagnoseOptions diagnosing;
  if (!options.settings.empty()) diagnosing.settings = diagnosis::read_settings(options.settings);
  if (options.explain) {
    print(diagnosis::settings_text(diagnosing.settings));
    return kDone;
  }
  diagnosing.accuracy.tolerances = options.tolerances;
  if (!options.horizon.empty())
    diagnosing.accuracy.horizon = diagnosis::read_horizon(options.horizon, "--horizon");
  if (options.datasets.empty())
    throw InputError("diagnose: no dataset given; allowed: one or more folders of datasets");

  std::vector<trajectory::Dataset> datasets;
  for (const std::string& folder : options.datasets)
    datasets.push_back(trajectory::read_dataset(folder));
  diagnosing.catalogue = std::make_shared<const effects::Catalogue>(
      effects::catalogue_for(options.effect_files, datasets));

  check_figures(options.common);
  if (!options.common.out.empty()) prepare_folder(options.common.out);
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism,
                                    options.common.jobs);
  diagnosing.progress = stage_bar(options.common, kStages);
  const diagnosis::Diagnosis diagnosis = diagnosis::diagnose(datasets, diagnosing);
  diagnosing.progress = {};
  clear_progress(options.common);
  if (!options.common.out.empty()) diagnosis::write_diagnosis(diagnosis, options.common.out);
  if (options.common.json) {
    print(diagnosis::diagnosis_json(diagnosis));
  } else if (!options.common.quiet) {
    print(diagnosis::diagnosis_text(diagnosis));
  }
  if (!options.common.out.empty()) {
    const std::filesystem::path first = std::filesystem::weakly_canonical(options.datasets.front());
    write_reporting(report::diagnosis_report(diagnosis, first.filename().string()), options.common);
  }
  return kDone;
}

}  // namespace

void add_diagnose(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<DiagnoseOptions>();
  options->common.jobs = 2;
  CLI::App* command = app.add_subcommand(
      "diagnose", "where the gap between model and robot lies, and which effect causes it");
  command->footer(
      "Several datasets of one robot are diagnosed together, an operating condition each.\n"
      "Example:\n  jaculus diagnose ../shared/data/pendulum/ak80 --out ak80_diagnosis");
  command->add_option("datasets", options->datasets, "folders of datasets");
  command->add_option("--settings", options->settings,
                      "YAML file of settings that replace defaults (--explain lists them)");
  command
      ->add_option("--tolerance", options->tolerances,
                   "held-out error that is good enough, by channel: x=5mm,pitch=1deg")
      ->delimiter(',');
  command->add_option("--horizon", options->horizon,
                      "since the start, up to which errors are judged: 0.1s; default: the whole "
                      "motion (0.1 s is stated beside it)");
  command
      ->add_option("--effects", options->effect_files,
                   "file of an effect of your own, judged beside the others; may be given several "
                   "times")
      ->allow_extra_args(false);
  command->add_flag("--explain", options->explain,
                    "print every setting with its unit, value and origin");
  add_common(*command, options->common,
             "folder for diagnosis.json, augmented.yaml and report.html");
  add_figures(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return run_diagnose(*options); }; });
}

}  // namespace jaculus::cli
