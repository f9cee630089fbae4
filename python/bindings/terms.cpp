// Constraints and costs that Python computes, and the check of a problem's derivatives.

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "bindings.h"
#include "jaculus/core/error.h"
#include "jaculus/core/units.h"
#include "jaculus/transcription/derivative_check.h"
#include "jaculus/transcription/guess.h"
#include "jaculus/transcription/nonlinear_program.h"
#include "jaculus/transcription/term.h"

namespace jaculus::python {
namespace {

using transcription::PathTerm;
using transcription::PointView;
using transcription::Reads;
using transcription::TermContext;
using transcription::TermSpec;
using transcription::TermType;

/// Blocks of a point in the order of xi; feet in contact differ by phase, so forces are left out.
const std::array<std::pair<const char*, bool Reads::*>, 4> kBlocks = {
    {{"position", &Reads::position},
     {"velocity", &Reads::velocity},
     {"input", &Reads::input},
     {"acceleration", &Reads::acceleration}}};

/// A number that a problem file gives: name, unit, meaning, default value.
using OwnKey = std::tuple<std::string, std::string, std::string, std::optional<std::string>>;
/// Name, unit, lower and upper bound, scale.
using OwnRow = std::tuple<std::string, std::string, double, double, double>;

/// Places in xi of what a term reads, in its order.
std::vector<int> places(const Reads& reads, int n, int n_u) {
  std::vector<int> at;
  int first = 0;
  for (const auto& [name, block] : kBlocks) {
    const int size = block == &Reads::input ? n_u : n;
    for (int j = first; reads.*block && j < first + size; ++j) at.push_back(j);
    first += size;
  }
  return at;
}

/// `function(numbers, derivatives, multipliers)` gives values, and by what is read the Jacobian by
/// rows and the multipliers' Hessian, each None where it isn't asked for.
struct PythonRows {
  std::shared_ptr<const nb::object> function;
  std::vector<int> at;

  void operator()(const PointView& view, VectorRef values, Matrix* J,
                  const ConstVectorRef* multipliers, Matrix* H) const {
    const bool done = call_user([&] {  // Ipopt would swallow an exception
      const nb::gil_scoped_acquire gil;
      compute_rows(view, values, J, H != nullptr ? multipliers : nullptr, H);
    });
    if (!done) values.setConstant(kNaN);
  }

 private:
  [[nodiscard]] static double number(const PointView& view, int at) {
    const int n = view.n, inputs_end = 2 * n + view.n_u;
    if (at < n) return view.point.q[at];
    if (at < 2 * n) return view.point.v[at - n];
    if (at < inputs_end) return view.u[at - 2 * n];
    return view.point.a[at - inputs_end];
  }

  void compute_rows(const PointView& view, VectorRef values, Matrix* J,
                    const ConstVectorRef* multipliers, Matrix* H) const {
    const std::size_t k = at.size();
    std::vector<double> numbers;
    for (const int place : at) numbers.push_back(number(view, place));
    nb::object weights = nb::none();
    if (multipliers != nullptr)
      weights = nb::cast(std::vector<double>(multipliers->begin(), multipliers->end()));

    const nb::object told = (*function)(nb::cast(numbers), J != nullptr, weights);
    const auto rows = nb::cast<std::vector<double>>(told[0]);
    for (std::size_t r = 0; r < rows.size(); ++r) values[static_cast<int>(r)] = rows[r];
    if (J != nullptr) {
      const auto entries = nb::cast<std::vector<double>>(told[1]);
      for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t j = 0; j < k; ++j) (*J)(static_cast<int>(r), at[j]) = entries[r * k + j];
    }
    if (H == nullptr) return;
    const auto entries = nb::cast<std::vector<double>>(told[2]);
    for (std::size_t i = 0; i < k; ++i)
      for (std::size_t j = 0; j < k; ++j) (*H)(at[i], at[j]) += entries[i * k + j];
  }
};

/// `make(keys, coordinates, motors)` gives the rows and the function of PythonRows.
struct PythonTerm {
  std::shared_ptr<const nb::object> make;
  std::vector<OwnKey> keys;
  Reads reads;
  bool cost = false, linear = false;

  void operator()(const TermSpec& spec, TermContext& context) const {
    const PathTerm term = built(spec, context);
    if (cost) {
      context.integral_costs.emplace_back(term, spec.weight);
      return;
    }
    for (const int phase : all_named(spec, "phases", context)) context.path[phase].push_back(term);
  }

 private:
  [[nodiscard]] PathTerm built(const TermSpec& spec, const TermContext& context) const {
    const nb::gil_scoped_acquire gil;
    nb::dict values;
    for (const OwnKey& key : keys) {
      const std::string& name = std::get<0>(key);
      values[name.c_str()] = spec.values.number(name);
    }
    std::vector<std::string> coordinates, motors;
    for (const model::Coordinate& c : context.model().coordinates) coordinates.push_back(c.name);
    for (const model::PlanarMotor& motor : context.model().motors) motors.push_back(motor.joint);
    const nb::object made = (*make)(values, nb::cast(coordinates), nb::cast(motors));

    PathTerm term;
    term.name = spec.name;
    for (const auto& [name, unit, lower, upper, scale] : nb::cast<std::vector<OwnRow>>(made[0]))
      term.rows.push_back({name, unit, {lower, upper}, scale});
    term.reads = reads;
    term.linear = linear;
    term.evaluate = PythonRows{held(made[1]), places(reads, context.layout.n, context.layout.n_u)};
    return term;
  }
};

TermType own_term(const std::string& name, const std::string& meaning, const std::string& unit,
                  const std::vector<OwnKey>& keys, const std::vector<std::string>& reads, bool cost,
                  bool linear, nb::object make) {
  namespace key = transcription::key;
  for (const TermType& type : transcription::term_catalogue())
    if (type.name == name)
      throw InputError("name: '" + name + "' is a term of jaculus; allowed: another name");

  PythonTerm own{held(std::move(make)), keys, {}, cost, linear};
  for (const auto& [block, flag] : kBlocks)
    own.reads.*flag = std::find(reads.begin(), reads.end(), block) != reads.end();
  TermType type;
  type.name = name;
  type.meaning = meaning;
  type.cost = cost;
  type.unit = unit;
  for (const auto& [own_name, own_unit, own_meaning, absent] : keys)
    type.keys.push_back({own_name,
                         key::Number{unit_dimension(own_unit), {}},
                         own_meaning,
                         {.value = absent.value_or("")}});
  if (!cost)
    type.keys.push_back({"phases", key::Names{key::Of::phase}, "list of phases", {.words = "all"}});
  type.make = std::move(own);
  return type;
}

transcription::LoadedProblem load(const yaml::Node& node, const std::vector<TermType>& own) {
  transcription::TermCatalogue catalogue = transcription::term_catalogue();
  for (const TermType& type : own) {
    const auto same = [&](const TermType& other) { return other.name == type.name; };
    if (std::any_of(catalogue.begin(), catalogue.end(), same))
      throw InputError("terms: '" + type.name + "' given twice; allowed: once");
    catalogue.push_back(type);
  }
  return transcription::load_problem(node, catalogue);
}

transcription::DerivativeReport check(const transcription::LoadedProblem& loaded, int seed,
                                      double spread) {
  return compute_whole([&] {
    transcription::NonlinearProgram program(
        loaded.problem, transcription::planning_model(loaded.problem, loaded.robot.planar));
    const Vector guess = transcription::initial_guess(program, loaded.problem.guess, 0);
    const auto drawn = static_cast<std::uint64_t>(seed);
    return check_derivatives(program, random_point(program, guess, spread, drawn), 1e-5, drawn);
  });
}

}  // namespace

void bind_terms(nb::module_& module) {
  nb::class_<TermType>(module, "Term").def_ro("name", &TermType::name);
  module.def("own_term", &own_term, nb::arg("name"), nb::arg("meaning"), nb::arg("unit"),
             nb::arg("keys"), nb::arg("reads"), nb::arg("cost"), nb::arg("linear"),
             nb::arg("make"));
  module.def("load_problem", &load, nb::arg("node"), nb::arg("terms"));

  using transcription::DerivativeError;
  using transcription::DerivativeReport;
  nb::class_<DerivativeError>(module, "DerivativeError")
      .def_ro("error", &DerivativeError::error)
      .def_ro("analytic", &DerivativeError::analytic)
      .def_ro("difference", &DerivativeError::difference)
      .def_ro("row", &DerivativeError::row)
      .def_ro("column", &DerivativeError::column);
  nb::class_<DerivativeReport>(module, "DerivativeReport")
      .def_ro("defined", &DerivativeReport::defined)
      .def_ro("gradient", &DerivativeReport::gradient)
      .def_ro("jacobian", &DerivativeReport::jacobian)
      .def_ro("hessian", &DerivativeReport::hessian);
  module.def("check_derivatives", &check, nb::arg("problem"), nb::arg("seed"), nb::arg("spread"));
}

}  // namespace jaculus::python
