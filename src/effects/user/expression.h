#pragma once
// An expression over named doubles, compiled once: muParser's byte code. What users may write:
//   numbers, names, + - * / ^, comparisons, && ||, a ? b : c, and functions() of one to three
//   arguments; pi.
// No assignment and no lists of results.

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace jaculus::effects {

/// What is wrong with an expression, and where.
struct ExpressionError : std::runtime_error {
  ExpressionError(const std::string& what, int its_column)
      : std::runtime_error(what), column(its_column) {}
  int column;  ///< 1-based
};

/// A name in an expression, functions and pi aside.
struct UsedName {
  std::string name;
  int column;  ///< 1-based, of its first use
};
std::vector<UsedName> names_in(const std::string& text);

/// Names that stand for no quantity: functions and pi.
const std::vector<std::string>& function_names();

class Expression {
 public:
  using Symbols = std::vector<std::pair<std::string, double*>>;
  /// ExpressionError where it can't be read. Every name in it must be one of `symbols`, which must
  /// outlive it where they are.
  Expression(const std::string& text, const Symbols& symbols);
  ~Expression();
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;

  /// At what the symbols are now. Not for several threads at once.
  [[nodiscard]] double value() const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace jaculus::effects
