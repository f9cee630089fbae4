// solution.json written, and earlier plans read back: solution.json or any CSV with the columns of
// plan.csv.

#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>
#include <fstream>

#include "jaculus/core/error.h"
#include "jaculus/solver/plan.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::solver {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kFormat = "jaculus-solution/1";

Json array(const ConstVectorRef& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

Json matrix(const Matrix& values) {
  Json rows = Json::array();
  for (int i = 0; i < values.rows(); ++i) rows.push_back(array(Vector(values.row(i).transpose())));
  return rows;
}

Vector vector_from(const Json& json) {
  const auto values = json.get<std::vector<double>>();
  return Eigen::Map<const Vector>(values.data(), values.size());
}

Matrix matrix_from(const Json& json, std::size_t rows, Eigen::Index columns) {
  if (json.size() != rows) throw std::runtime_error("a table whose rows do not match its names");
  Matrix values(rows, columns);
  for (std::size_t i = 0; i < rows; ++i) {
    const Vector row = vector_from(json[i]);
    if (row.size() != columns) throw std::runtime_error("a row that is not as long as its plan");
    values.row(i) = row.transpose();
  }
  return values;
}

Json trajectory_json(const trajectory::Trajectory& t) {
  Json phases = Json::array();
  for (const trajectory::PhaseSpan& span : t.phases)
    phases.push_back({{"name", span.name},
                      {"contacts", span.contacts},
                      {"first", span.first},
                      {"last", span.last}});
  return {{"coordinates", t.coordinates},
          {"motors", t.motors},
          {"phases", phases},
          {"input_hold", t.input_hold},
          {"time", array(t.time)},
          {"position", matrix(t.position)},
          {"velocity", matrix(t.velocity)},
          {"torque", matrix(t.torque)}};
}

trajectory::Trajectory trajectory_from(const Json& json) {
  trajectory::Trajectory t;
  t.coordinates = json.at("coordinates").get<std::vector<std::string>>();
  t.motors = json.at("motors").get<std::vector<std::string>>();
  t.input_hold = json.at("input_hold").get<std::string>();
  t.time = vector_from(json.at("time"));
  const int samples = t.samples();

  for (const Json& phase : json.at("phases")) {
    trajectory::PhaseSpan span{phase.at("name").get<std::string>(),
                               phase.at("contacts").get<std::vector<std::string>>(),
                               phase.at("first").get<int>(), phase.at("last").get<int>()};
    if (span.first < 0 || span.last < span.first || span.last >= samples)
      throw std::runtime_error("a phase outside the plan");
    t.phases.push_back(span);
  }

  t.position = matrix_from(json.at("position"), t.coordinates.size(), samples);
  t.velocity = matrix_from(json.at("velocity"), t.coordinates.size(), samples);
  t.torque = matrix_from(json.at("torque"), t.motors.size(), samples);
  return t;
}

EarlierPlan solution_from(const Json& json) {
  if (json.at("format") != kFormat)
    throw std::runtime_error(fmt::format("its format is not {}", kFormat));
  EarlierPlan plan;
  plan.trajectory = trajectory_from(json.at("trajectory"));
  const Json &variables = json.at("variables"), &rows = json.at("rows");
  plan.variables = variables.at("names").get<std::vector<std::string>>();
  plan.rows = rows.at("names").get<std::vector<std::string>>();
  plan.x = vector_from(variables.at("values"));
  const Duals duals{vector_from(rows.at("multipliers")),
                    vector_from(variables.at("lower_multipliers")),
                    vector_from(variables.at("upper_multipliers"))};
  const auto n = std::ssize(plan.variables), m = std::ssize(plan.rows);
  if (plan.x.size() != n || duals.lower.size() != n || duals.upper.size() != n ||
      duals.rows.size() != m)
    throw std::runtime_error("values and names differ in number");
  if (json.at("converged").get<bool>()) plan.duals = duals;
  return plan;
}

EarlierPlan read_solution(const std::filesystem::path& file) {
  std::ifstream stream(file);
  const std::string allowed = "allowed: a solution.json that jaculus wrote, or a plan.csv";
  if (!stream) throw InputError(fmt::format("{}: can't be read; {}", file.string(), allowed));
  try {
    return solution_from(Json::parse(stream));
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: {}; {}", file.string(), error.what(), allowed));
  }
}

/// A row of the linear map from coordinates to what a column of the file holds.
struct Observation {
  std::string column;
  bool angular = true;
  Vector map;           ///< coordinates -> value
  double offset = 0.0;  ///< [rad or m]
};

std::vector<Observation> observations(const trajectory::Table& table,
                                      const model::PlanarModel& model) {
  std::vector<Observation> found;
  for (int i = 0; i < model.size(); ++i) {
    const model::Coordinate& c = model.coordinates[i];
    if (table.column(c.name) >= 0)
      found.push_back({c.name, c.angular, Vector::Unit(model.size(), i), 0.0});
  }
  for (int b = 1; b < count_of(model.bodies); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    const Vector map = model.joint_map.row(b).transpose();
    if (map.isZero() || table.column(body.joint) < 0 || model.coordinate_index(body.joint) >= 0)
      continue;
    found.push_back(
        {body.joint, body.kind == model::JointKind::revolute, map, model.joint_offset[b]});
  }
  return found;
}

/// Coordinates from all columns of the file that depend on them, by least squares; those that none
/// sees are left out.
void read_coordinates(const trajectory::Table& table, const model::PlanarModel& model,
                      const std::filesystem::path& file, trajectory::Trajectory& t) {
  const std::vector<Observation> seen = observations(table, model);
  const auto rows = std::ssize(seen);
  if (rows == 0)
    throw InputError(fmt::format(
        "{}:1: no column of a coordinate or joint of this robot; allowed: a plan of a robot "
        "that shares some, as 'x [m]' or '<joint> [rad]'",
        file.string()));

  Matrix map(rows, model.size()), position(rows, table.values.rows()),
      velocity(rows, table.values.rows());
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Observation& o = seen[i];
    map.row(i) = o.map.transpose();
    position.row(i) = trajectory::quantity(table, o.column,
                                           o.angular ? dimension::angle : dimension::length, file)
                          .transpose();
    position.row(i).array() -= o.offset;
    velocity.row(i) =
        trajectory::quantity(table, o.column + "_velocity",
                             o.angular ? dimension::angular_velocity : dimension::velocity, file)
            .transpose();
  }

  const Eigen::CompleteOrthogonalDecomposition<Matrix> solver(map);
  const Matrix q = solver.solve(position), v = solver.solve(velocity);
  const Matrix resolution = solver.solve(map);  // the identity where coordinates are determined

  std::vector<int> kept;
  for (int i = 0; i < model.size(); ++i)
    if (std::abs(resolution(i, i) - 1.0) < 1e-9) kept.push_back(i);

  t.position.resize(kept.size(), q.cols());
  t.velocity.resize(t.position.rows(), q.cols());
  for (int k = 0; k < count_of(kept); ++k) {
    const model::Coordinate& c = model.coordinates[kept[k]];
    t.coordinates.push_back(c.name);
    t.angular.push_back(c.angular);
    t.position.row(k) = q.row(kept[k]);
    t.velocity.row(k) = v.row(kept[k]);
  }
}

void read_phases(const trajectory::Table& table, trajectory::Trajectory& t) {
  const auto name = [&](int k) {
    return table.phase.empty() ? std::string("plan") : table.phase[k];
  };
  for (int k = 0; k < t.samples(); ++k) {
    if (k == 0 || name(k) != name(k - 1)) t.phases.push_back({name(k), {}, k, k});
    t.phases.back().last = k;
  }
}

trajectory::Trajectory read_csv_plan(const std::filesystem::path& file,
                                     const model::PlanarModel& model) {
  const trajectory::Table table = trajectory::read_csv(file);
  trajectory::Trajectory t;
  t.time = trajectory::quantity(table, "time", dimension::time, file);
  read_coordinates(table, model, file, t);

  for (const model::PlanarMotor& motor : model.motors)
    if (table.column(motor.joint + "_torque") >= 0) t.motors.push_back(motor.joint);
  t.torque.resize(t.motors.size(), t.samples());
  for (int m = 0; m < count_of(t.motors); ++m) {
    const int body = model.motors[model.motor_index(t.motors[m])].body;
    const bool turns = model.bodies[body].kind == model::JointKind::revolute;
    t.torque.row(m) = trajectory::quantity(table, t.motors[m] + "_torque",
                                           turns ? dimension::torque : dimension::force, file)
                          .transpose();
  }

  if (!t.time.allFinite() || !t.position.allFinite() || !t.velocity.allFinite() ||
      !t.torque.allFinite())
    throw InputError(
        fmt::format("{}: has gaps; allowed: a plan with a number in every cell", file.string()));
  for (int k = 1; k < t.samples(); ++k)
    if (t.time[k] < t.time[k - 1])
      throw InputError(
          fmt::format("{}:{}: time falls; allowed: times in order", file.string(), k + 2));

  read_phases(table, t);
  return t;
}

}  // namespace

Json solution_json(const Plan& plan) {
  const transcription::NonlinearProgram& program = *plan.program;
  const NlpResult& result = plan.result;
  if (!plan.trajectory || result.last_iterate().size() != program.variables()) return nullptr;

  Json json = {{"format", kFormat},
               {"problem", program.problem().name},
               {"status", to_string(result.status)},
               {"converged", result.converged()},
               {"objective", result.objective}};

  std::vector<std::string> variables, rows;
  for (int i = 0; i < program.variables(); ++i) variables.push_back(program.variable_name(i));
  for (int i = 0; i < program.rows(); ++i) rows.push_back(program.row_name(i));
  json["variables"] = {{"names", variables},
                       {"values", array(result.last_iterate())},
                       {"lower_multipliers", array(result.lower_multipliers)},
                       {"upper_multipliers", array(result.upper_multipliers)}};
  json["rows"] = {{"names", rows}, {"multipliers", array(result.row_multipliers)}};

  for (const MeshRound& round : plan.mesh_rounds) {
    json["mesh_rounds"].push_back({{"intervals", round.intervals},
                                   {"objective", round.objective},
                                   {"duration_s", round.duration},
                                   {"liftoff_velocity_m_s", round.final_velocity},
                                   {"interval_error", round.interval_error},
                                   {"iterations", round.iterations}});
  }

  json["trajectory"] = trajectory_json(*plan.trajectory);
  return json;
}

EarlierPlan read_earlier_plan(const std::filesystem::path& file, const model::PlanarModel& model) {
  if (file.extension() != ".csv") return read_solution(file);
  EarlierPlan plan;
  plan.trajectory = read_csv_plan(file, model);
  return plan;
}

trajectory::Trajectory read_trajectory(const std::filesystem::path& file,
                                       const model::PlanarModel& model) {
  return read_earlier_plan(file, model).trajectory;
}

}  // namespace jaculus::solver
