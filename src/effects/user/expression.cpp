#include "effects/user/expression.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

namespace jaculus::effects {

namespace {

double sign_of(double x) { return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0); }

/// The names that a formula may call; each with muParser's callback.
struct Function {
  const char* name;
  double (*one)(double) = nullptr;
  double (*two)(double, double) = nullptr;
};

constexpr Function kFunctions[] = {
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"tan", [](double x) { return std::tan(x); }},
    {"asin", [](double x) { return std::asin(x); }},
    {"acos", [](double x) { return std::acos(x); }},
    {"atan", [](double x) { return std::atan(x); }},
    {"sinh", [](double x) { return std::sinh(x); }},
    {"cosh", [](double x) { return std::cosh(x); }},
    {"tanh", [](double x) { return std::tanh(x); }},
    {"exp", [](double x) { return std::exp(x); }},
    {"ln", [](double x) { return std::log(x); }},
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"abs", [](double x) { return std::abs(x); }},
    {"sign", sign_of},
    {"floor", [](double x) { return std::floor(x); }},
    {"atan2", nullptr, [](double y, double x) { return std::atan2(y, x); }},
    {"hypot", nullptr, [](double x, double y) { return std::hypot(x, y); }},
    {"min", nullptr, [](double a, double b) { return std::min(a, b); }},
    {"max", nullptr, [](double a, double b) { return std::max(a, b); }},
    {"mod", nullptr, [](double a, double b) { return a - b * std::floor(a / b); }},
};

constexpr const char* kNameCharacters =
    "0123456789_.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

bool opens_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool in_name(char c) { return opens_name(c) || digit(c) || c == '.'; }

/// Past the number that begins at `at`.
std::size_t number_end(const std::string& text, std::size_t at) {
  while (at < text.size() && (digit(text[at]) || text[at] == '.')) ++at;
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    std::size_t exponent = at + 1;
    if (exponent < text.size() && (text[exponent] == '+' || text[exponent] == '-')) ++exponent;
    if (exponent < text.size() && digit(text[exponent])) {
      while (exponent < text.size() && digit(text[exponent])) ++exponent;
      at = exponent;
    }
  }
  return at;
}

/// muParser takes a single = for an assignment, a quote for text, and # for its own.
void refuse_statements(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], before = i > 0 ? text[i - 1] : ' ';
    const char after = i + 1 < text.size() ? text[i + 1] : ' ';
    const int column = static_cast<int>(i) + 1;
    const bool compares =
        after == '=' || before == '=' || before == '<' || before == '>' || before == '!';
    if (c == '=' && !compares) throw ExpressionError("'=' assigns, == compares", column);
    if (std::string("\"'#;@$").find(c) != std::string::npos)
      throw ExpressionError(fmt::format("unexpected '{}'", c), column);
  }
}

}  // namespace

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Function& function : kFunctions) all.emplace_back(function.name);
    all.emplace_back("pi");
    return all;
  }();
  return names;
}

std::vector<UsedName> names_in(const std::string& text) {
  const std::vector<std::string>& functions = function_names();
  std::vector<UsedName> used;
  for (std::size_t i = 0; i < text.size();) {
    if (digit(text[i]) || text[i] == '.') {
      i = std::max(i + 1, number_end(text, i));
      continue;
    }
    if (!opens_name(text[i])) {
      ++i;
      continue;
    }
    const std::size_t from = i;
    while (i < text.size() && in_name(text[i])) ++i;
    const std::string name = text.substr(from, i - from);
    const bool known =
        std::find(functions.begin(), functions.end(), name) != functions.end() ||
        std::any_of(used.begin(), used.end(), [&](const UsedName& u) { return u.name == name; });
    if (!known) used.push_back({name, static_cast<int>(from) + 1});
  }
  return used;
}

struct Expression::Parser {
  mu::Parser parser;
};

Expression::Expression(const std::string& text, const Symbols& symbols)
    : parser_(std::make_unique<Parser>()) {
  refuse_statements(text);
  mu::Parser& parser = parser_->parser;
  parser.DefineNameChars(kNameCharacters);
  parser.ClearFun();
  parser.ClearConst();
  parser.DefineConst("pi", std::numbers::pi);
  for (const Function& function : kFunctions) {
    if (function.one != nullptr) parser.DefineFun(function.name, function.one);
    if (function.two != nullptr) parser.DefineFun(function.name, function.two);
  }

  try {
    for (const auto& [name, at] : symbols) parser.DefineVar(name, at);
    parser.SetExpr(text);
    int results = 0;
    parser.Eval(results);
    if (results != 1) throw ExpressionError("',' outside of a function", 1);
  } catch (const mu::Parser::exception_type& e) {
    const int column = std::clamp(static_cast<int>(e.GetPos()), 0, static_cast<int>(text.size()));
    std::string what = e.GetMsg();
    what = what.substr(0, what.find(" found at position"));
    what = what.substr(0, what.find(" at position"));
    if (!what.empty() && what.back() == '.') what.pop_back();
    if (!what.empty()) what[0] = static_cast<char>(std::tolower(what[0]));
    throw ExpressionError(what, column + 1);
  }
}

Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;

double Expression::value() const { return parser_->parser.Eval(); }

}  // namespace jaculus::effects
