// jaculus diagnose: why a robot did something else than its plan.

#include "jaculus/diagnosis/diagnose.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <memory>

#include "cli/reporting.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/report/diagnosis_report.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

struct Options {
  Common common;
  std::vector<std::string> datasets;
};

/// Part of the time that lies behind where a stage first begins: rough, from leaps of the plant.
const std::vector<std::pair<std::string, double>> kStages = {{"screening", 0.003},
                                                             {"single effects", 0.01},
                                                             {"pairs of effects", 0.25},
                                                             {"triples of effects", 0.5},
                                                             {"held-out gap and intervals", 0.8},
                                                             {"where the gap lies", 0.9}};

int run(const Options& options) {
  std::vector<Dataset> datasets;
  for (const std::string& folder : options.datasets) datasets.push_back(read_dataset(folder));
  check_figures(options.common);
  if (!options.common.out.empty()) prepare_folder(options.common.out);
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(options.common.jobs));
  DiagnoseOptions diagnosing;
  diagnosing.progress = stage_bar(options.common, kStages);
  const Diagnosis diagnosis = diagnose(datasets, diagnosing);
  clear_progress(options.common);
  const std::string json = diagnosis_json(diagnosis);
  if (!options.common.out.empty()) {
    const std::filesystem::path folder = options.common.out;
    write_file(folder / "diagnosis.json", json);
    write_file(folder / "augmented.yaml", augmented_yaml(diagnosis));
  }
  if (options.common.json) {
    print(json);
  } else if (!options.common.quiet) {
    print(diagnosis_text(diagnosis));
  }
  if (!options.common.out.empty()) {
    const std::filesystem::path first = std::filesystem::weakly_canonical(options.datasets.front());
    write_reporting(diagnosis_report(diagnosis, first.filename().string()), options.common);
  }
  return kDone;
}

}  // namespace

void add_diagnose(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<Options>();
  options->common.jobs = 2;
  CLI::App* command =
      app.add_subcommand("diagnose", "where the gap between model and robot lies, and which effect causes it");
  command->footer(
      "Several datasets of one robot are diagnosed together, an operating condition each.\n"
      "Example:\n  jaculus diagnose ../shared/data/pendulum/ak80 --out ak80_diagnosis");
  command->add_option("datasets", options->datasets, "folders of datasets")->required();
  add_common(*command, options->common, "folder for diagnosis.json, augmented.yaml and report.html");
  add_figures(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace jaculus::cli
