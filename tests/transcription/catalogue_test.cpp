// Every term of the catalogue against central differences, and the checker against planted faults.

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "jaculus/transcription/derivative_check.h"
#include "transcription/example_problems.h"
#include "transcription/own_term.h"

namespace jaculus::transcription {
namespace {

using test::extended_problem;
using test::make_program;
using test::on_grid;

constexpr double kTolerance = 1e-6;

/// The library's terms, and one that only this test knows: whatever is in a catalogue is checked.
const TermCatalogue& catalogue() {
  static const TermCatalogue terms = test::catalogue_with_own_term();
  return terms;
}

struct Case {
  TermType type;
  Scheme scheme;
  InputHold inputs;
};

std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.type.name; }

std::string case_name(const testing::TestParamInfo<Case>& info) {
  return info.param.type.name +
         (info.param.scheme == Scheme::trapezoidal ? "_trapezoidal" : "_hermite_simpson") +
         (info.param.inputs == InputHold::linear ? "_linear" : "_held");
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const TermType& type : catalogue())
    for (Scheme scheme : {Scheme::hermite_simpson, Scheme::trapezoidal})
      for (InputHold inputs : {InputHold::held, InputHold::linear})
        cases.push_back({type, scheme, inputs});
  return cases;
}

/// The leap with no term but the one under test, which has the keys of its example.
Problem leap_with(const Case& c) {
  const std::string term = c.type.in_file("under_test");
  const std::string lines =
      c.type.cost ? "objective: {minimise: [" + term + "]}" : "constraints: [" + term + "]";
  Problem problem = on_grid(extended_problem("leap_tail", lines, catalogue()), {3, 2});

  const auto other = [](const TermSpec& spec) { return spec.name != "under_test"; };
  std::erase_if(problem.constraints, other);
  std::erase_if(problem.objective, other);

  problem.transcription.scheme = c.scheme;
  problem.transcription.inputs = c.inputs;
  problem.transcription.check_interval_end = true;
  return problem;
}

void expect_exact(NonlinearProgram& program, const Vector& x) {
  const DerivativeReport report = check_derivatives(program, x);
  ASSERT_TRUE(report.defined);
  for (const auto& [what, error] :
       {std::pair("gradient", report.gradient), std::pair("Jacobian", report.jacobian),
        std::pair("Hessian", report.hessian)}) {
    EXPECT_LT(error.error, kTolerance)
        << what << ": " << error.row << " by " << error.column << ": " << error.analytic
        << " where differences give " << error.difference;
  }
}

class CatalogueTerm : public testing::TestWithParam<Case> {};

TEST_P(CatalogueTerm, HasExactDerivatives) {
  const Problem problem = leap_with(GetParam());
  ASSERT_EQ(problem.constraints.size() + problem.objective.size(), 1U);
  model::PlanarModel model = test::model_of(problem);
  // This robot has no range on which joint_range makes rows; one on a motor's joint gives it some.
  model.joint_ranges.push_back({"front_a", model.body_of_joint("front_a"), {0.2, 3.0}});
  NonlinearProgram program(problem, model);
  const Vector guess = initial_guess(program, test::leap_guess(), 0);

  Problem without = problem;
  without.constraints.clear();
  without.objective.clear();
  const NonlinearProgram bare(without, model);
  if (GetParam().type.cost) {
    double value = 0.0;
    ASSERT_TRUE(program.objective(guess, value));
    EXPECT_NE(value, 0.0) << "the cost does nothing";
  } else {
    EXPECT_GT(program.rows(), bare.rows()) << "the constraint has no rows";
  }

  expect_exact(program, random_point(program, guess, 0.05, 7));
}

INSTANTIATE_TEST_SUITE_P(All, CatalogueTerm, testing::ValuesIn(all_cases()), case_name);

class WholeProblem : public testing::TestWithParam<std::pair<const char*, std::vector<int>>> {};

TEST_P(WholeProblem, HasExactDerivatives) {
  const auto& [name, grid] = GetParam();
  NonlinearProgram program = make_program(on_grid(read_problem(test::problem_file(name)), grid));
  for (std::uint64_t seed : {1, 2}) {
    SCOPED_TRACE(seed);
    const Vector guess = initial_guess(program, program.problem().guess, 0);
    expect_exact(program, random_point(program, guess, 0.03, seed));
  }
}

INSTANTIATE_TEST_SUITE_P(All, WholeProblem,
                         testing::Values(std::pair("leap_tail", std::vector<int>{3, 2}),
                                         std::pair("leap_inactive", std::vector<int>{3, 2}),
                                         std::pair("hop", std::vector<int>{2, 2, 2}),
                                         std::pair("bound_step", std::vector<int>{2, 1, 1, 1, 1}),
                                         std::pair("pendulum_swing_up", std::vector<int>{4}),
                                         std::pair("double_integrator", std::vector<int>{4})),
                         [](const auto& info) { return std::string(info.param.first); });

// ---- the checker

/// A program with one fault of its derivatives.
class Faulty : public Nlp {
 public:
  enum class Fault {
    none,
    jacobian_entry,
    jacobian_pattern,
    hessian_pattern,
    gradient_entry,
    not_a_number
  };
  Faulty(NonlinearProgram& inner, Fault fault)
      : inner_(inner),
        fault_(fault),
        jacobian_(inner.jacobian_sparsity()),
        hessian_(inner.hessian_sparsity()) {
    if (fault == Fault::jacobian_pattern) cut(jacobian_, 0);
    if (fault == Fault::hessian_pattern) cut(hessian_, dropped_ = largest_hessian_entry());
  }
  int variables() const override { return inner_.variables(); }
  int rows() const override { return inner_.rows(); }
  const Vector& variable_lower() const override { return inner_.variable_lower(); }
  const Vector& variable_upper() const override { return inner_.variable_upper(); }
  const Vector& row_lower() const override { return inner_.row_lower(); }
  const Vector& row_upper() const override { return inner_.row_upper(); }
  const Vector& variable_scale() const override { return inner_.variable_scale(); }
  const Vector& row_scale() const override { return inner_.row_scale(); }
  double objective_scale() const override { return inner_.objective_scale(); }
  std::string variable_name(int column) const override { return inner_.variable_name(column); }
  std::string row_name(int row) const override { return inner_.row_name(row); }
  std::string variable_unit(int column) const override { return inner_.variable_unit(column); }
  std::string row_unit(int row) const override { return inner_.row_unit(row); }
  const Sparsity& jacobian_sparsity() const override { return jacobian_; }
  const Sparsity& hessian_sparsity() const override { return hessian_; }
  bool objective(const ConstVectorRef& x, double& value) override {
    return inner_.objective(x, value);
  }
  bool constraints(const ConstVectorRef& x, VectorRef values) override {
    return inner_.constraints(x, values);
  }
  bool gradient(const ConstVectorRef& x, VectorRef out) override {
    const bool defined = inner_.gradient(x, out);
    if (fault_ == Fault::gradient_entry) out[2] += 1e-3;
    return defined;
  }
  bool jacobian(const ConstVectorRef& x, VectorRef out) override {
    Vector all(inner_.jacobian_sparsity().size());
    const bool defined = inner_.jacobian(x, all);
    out = fault_ == Fault::jacobian_pattern ? Vector(all.tail(out.size())) : all;
    if (fault_ == Fault::jacobian_entry) out[5] += 1e-3;
    if (fault_ == Fault::not_a_number) out[5] = kNaN;
    return defined;
  }
  bool hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
               VectorRef out) override {
    Vector all(inner_.hessian_sparsity().size());
    const bool defined = inner_.hessian(x, sigma, lambda, all);
    if (fault_ == Fault::hessian_pattern) {
      out.head(dropped_) = all.head(dropped_);
      out.tail(out.size() - dropped_) = all.tail(out.size() - dropped_);
    } else {
      out = all;
    }
    return defined;
  }

 private:
  static void cut(Sparsity& s, int at) {
    s.rows.erase(s.rows.begin() + at);
    s.columns.erase(s.columns.begin() + at);
  }
  int largest_hessian_entry() {
    Vector values(hessian_.size());
    const Vector guess = initial_guess(inner_, inner_.problem().guess, 0);
    EXPECT_TRUE(
        inner_.hessian(random_point(inner_, guess, 0.03, 1), 1.0, Vector::Ones(rows()), values));
    int at = 0;
    values.cwiseAbs().maxCoeff(&at);
    return at;
  }
  NonlinearProgram& inner_;
  Fault fault_;
  Sparsity jacobian_, hessian_;
  int dropped_ = 0;
};

TEST(DerivativeCheck, FindsEachPlantedFault) {
  using Fault = Faulty::Fault;
  NonlinearProgram program =
      make_program(on_grid(read_problem(test::problem_file("pendulum_swing_up")), {4}));
  const Vector x =
      random_point(program, initial_guess(program, program.problem().guess, 0), 0.03, 1);
  const auto report = [&](Fault fault) {
    Faulty nlp(program, fault);
    return check_derivatives(nlp, x);
  };
  const DerivativeReport sound = report(Fault::none);
  ASSERT_TRUE(sound.defined);
  EXPECT_LT(std::max({sound.gradient.error, sound.jacobian.error, sound.hessian.error}),
            kTolerance);

  const DerivativeReport wrong = report(Fault::jacobian_entry);
  EXPECT_GT(wrong.jacobian.error, 1e-4);
  EXPECT_EQ(wrong.jacobian.row, program.row_name(program.jacobian_sparsity().rows[5]));
  EXPECT_EQ(wrong.jacobian.column, program.variable_name(program.jacobian_sparsity().columns[5]));
  EXPECT_NEAR(wrong.jacobian.analytic - wrong.jacobian.difference, 1e-3, 1e-8);

  EXPECT_GT(report(Fault::jacobian_pattern).jacobian.error, 1e-3);
  EXPECT_GT(report(Fault::hessian_pattern).hessian.error, 1e-3);
  EXPECT_GT(report(Fault::gradient_entry).gradient.error, 1e-5);
  EXPECT_EQ(report(Fault::gradient_entry).gradient.column, program.variable_name(2));
  EXPECT_EQ(report(Fault::not_a_number).jacobian.error, kInfinity);
}

}  // namespace
}  // namespace jaculus::transcription
