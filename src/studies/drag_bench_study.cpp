#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <sstream>

#include "jaculus/core/journal.h"
#include "jaculus/trajectory/csv.h"
#include "studies/drag_fit.h"
#include "studies/setup.h"
#include "studies/study_kind.h"

// Studies of kind `drag_bench`:
//   data: bench.csv              columns voltage [V], current [A], speed [rad/s]; transient: time
//                                [s] too
//   log: steady | transient      transient: inertia (all that turns, about the tail's axis) and
//                                window besides
//   speed_of: tail | motor       motor: gear besides
//   resistance: 0.186 ohm
//   tail: {length: ..., shaft: ..., width: ...}
//   air_density: 1.225 kg/m^3
//   confidence: 0.95

namespace jaculus::studies {
namespace {

namespace dim = dimension;

struct Bench {
  std::vector<DragObservation> observations;
  double density, width, shaft, length, confidence;
  std::string data;  // the file's bytes, which the result depends on
};

// A column without gaps.
std::vector<double> full_column(const trajectory::Table& table, const std::string& name,
                                const Dimension& dimension, const std::filesystem::path& file) {
  const Vector v = quantity(table, name, dimension, file);
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (std::isfinite(v(i))) continue;
    throw InputError(
        fmt::format("{}:{}: {}: empty; every row needs a number", file.string(), i + 2, name));
  }
  return {v.data(), v.data() + v.size()};
}

std::vector<DragObservation> read_steady(const yaml::Node& root, const trajectory::Table& table,
                                         const std::filesystem::path& file, double gear,
                                         double resistance) {
  for (const char* key : {"inertia", "window"}) {
    if (root.has(key)) throw root.at(key).error("only a transient log needs this");
  }
  const std::vector<double> v = full_column(table, "voltage", dim::voltage, file);
  const std::vector<double> i = full_column(table, "current", dim::current, file);
  const std::vector<double> w = full_column(table, "speed", dim::angular_velocity, file);
  std::vector<BenchPoint> points;
  for (std::size_t k = 0; k < v.size(); ++k) {
    points.push_back({v[k], i[k], w[k] / gear});
    const std::string fault = bench_fault(points.back(), resistance);
    if (!fault.empty()) throw InputError(fmt::format("{}:{}: {}", file.string(), k + 2, fault));
  }
  return steady_observations(points, resistance);
}

std::vector<DragObservation> read_transient(const yaml::Node& root, const trajectory::Table& table,
                                            const std::filesystem::path& file, double gear,
                                            double resistance) {
  const double inertia = root.at("inertia").number(dim::inertia, kPositive);
  const double window = root.at("window").number(dim::time, kPositive);

  const std::vector<double> t = full_column(table, "time", dim::time, file);
  std::vector<double> w = full_column(table, "speed", dim::angular_velocity, file);
  for (double& speed : w) speed /= gear;

  std::vector<double> power(t.size(), 0.0);
  if (table.column("voltage") >= 0 || table.column("current") >= 0) {
    const std::vector<double> v = full_column(table, "voltage", dim::voltage, file);
    const std::vector<double> i = full_column(table, "current", dim::current, file);
    for (std::size_t k = 0; k < v.size(); ++k) power[k] = v[k] * i[k] - resistance * i[k] * i[k];
  }

  for (std::size_t k = 1; k < t.size(); ++k) {
    if (!(t[k] > t[k - 1]))
      throw InputError(
          fmt::format("{}:{}: time: it must rise from row to row", file.string(), k + 2));
  }

  return transient_observations(t, w, power, inertia, window);
}

Bench read_bench(const yaml::Node& root) {
  root.only(detail::with_common_keys({"data", "log", "inertia", "window", "speed_of", "gear",
                                      "resistance", "tail", "air_density", "confidence"}));
  Bench bench;

  const yaml::Node tail = root.at("tail");
  tail.only({"length", "shaft", "width"});
  bench.length = tail.at("length").number(dim::length, kPositive);
  bench.shaft = tail.at("shaft").number(dim::length, {0.0, 1e12});
  bench.width = tail.at("width").number(dim::length, kPositive);
  if (!(bench.shaft < bench.length)) {
    throw tail.at("shaft").error(
        fmt::format("{} m; it must be below the length of {} m", bench.shaft, bench.length));
  }

  bench.density = root.at("air_density").number(dim::density, kPositive);
  bench.confidence = root.at("confidence").number(dim::none, {0.5, 0.9999});
  const double resistance = root.at("resistance").number(dim::resistance, kPositive);
  const bool at_motor = root.at("speed_of").choice({"tail", "motor"}) == "motor";
  if (!at_motor && root.has("gear")) throw root.at("gear").error("only speed_of: motor needs this");
  const double gear = at_motor ? root.at("gear").number(dim::none, kPositive) : 1.0;
  const bool transient = root.at("log").choice({"steady", "transient"}) == "transient";

  const std::filesystem::path file = detail::named_file(root.at("data"));
  const trajectory::Table table = trajectory::read_csv(file);
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  bench.data = bytes.str();

  bench.observations = transient ? read_transient(root, table, file, gear, resistance)
                                 : read_steady(root, table, file, gear, resistance);

  if (bench.observations.size() < 2) {
    throw InputError(
        fmt::format("{}: {} usable {}; the least is 2, one more than the unknowns of drag alone",
                    file.string(), bench.observations.size(), transient ? "windows" : "points"));
  }

  return bench;
}

void put(StudyJson& row, const std::string& stem, const std::string& unit, const Estimate& e) {
  row[stem + unit] = json_number(e.value);
  row[stem + "_low" + unit] = json_number(e.low);
  row[stem + "_high" + unit] = json_number(e.high);
}

StudyJson rows_of(const Bench& bench, const DragFits& fits) {
  StudyJson rows = StudyJson::array();
  for (int i = 0; i < count_of(fits.fits); ++i) {
    const DragFit& fit = fits.fits[i];
    StudyJson row{{"model", fit.model}, {"taken", i == fits.taken ? "yes" : "no"}};
    row["plausible"] = fit.plausible ? "yes" : "no";

    put(row, "drag_coefficient", "",
        drag_coefficient(fit.quadratic, bench.density, bench.width, bench.shaft, bench.length));
    put(row, "quadratic", "_N_m_s2", fit.quadratic);
    put(row, "viscous", "_N_m_s", fit.viscous);
    put(row, "coulomb", "_N_m", fit.coulomb);

    row["r_squared"] = json_number(fit.r_squared);
    row["residual_N_m"] = json_number(fit.residual);
    row["aicc"] = json_number(fit.aicc);
    row["condition"] = json_number(fit.condition);
    row["points"] = bench.observations.size();
    row["confidence"] = bench.confidence;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

detail::PreparedStudy detail::prepare_drag_bench(const yaml::Node& root) {
  const auto bench = std::make_shared<const Bench>(read_bench(root));
  PreparedStudy study;
  study.description = fmt::format("{} observations, up to four models", bench->observations.size());
  study.fingerprint = bench->data;
  study.tasks = 1;
  for (const DragObservation& o : bench->observations)
    study.samples.push_back({{"speed_rad_s", o.viscous}, {"torque_N_m", o.torque}});
  const auto fitted = [bench] { return fit_drag(bench->observations, bench->confidence); };
  const StudyJson rows = rows_of(*bench, fitted());
  for (const auto& item : rows[0].items()) study.columns.push_back(item.key());
  study.task = [bench, fitted](int) { return rows_of(*bench, fitted()).dump(); };
  study.rows = [](const std::vector<std::string>& bytes) {
    return StudyJson::parse(bytes[0]).get<std::vector<StudyJson>>();
  };
  study.notes = [fitted](const std::vector<StudyJson>&) { return fitted().notes; };
  return study;
}

}  // namespace jaculus::studies
