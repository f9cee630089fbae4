#pragma once
// What a reader does with a robot file of somebody else's that it can't take as it stands: it
// assumes something and says so, or, where the user asks for strictness, refuses.

#include <filesystem>
#include <string>
#include <vector>

namespace jaculus::model {

class Assumptions {
 public:
  Assumptions(std::filesystem::path file, bool strict) : file_(std::move(file)), strict_(strict) {}

  /// `fault` as in an error's message, "what was given; allowed: what is"; `taken`: what is done
  /// instead. Strict: InputError with the line.
  void assume(int line, const std::string& fault, const std::string& taken);

  /// InputError with the line: what nothing can be assumed for.
  [[noreturn]] void refuse(int line, const std::string& fault) const;

  /// One sentence each, "assumed: what was given: what is taken (line 5)"; what comes often is
  /// counted.
  [[nodiscard]] std::vector<std::string> notes() const;

  [[nodiscard]] bool strict() const { return strict_; }

 private:
  struct Item {
    std::string text;
    int line = 0;
    int count = 1;
  };
  std::filesystem::path file_;
  bool strict_ = false;
  std::vector<Item> items_;
};

}  // namespace jaculus::model
