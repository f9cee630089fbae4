// What names of joints and links tell.

#include <algorithm>
#include <array>
#include <cctype>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

bool any_of(const std::vector<std::string>& words, std::initializer_list<const char*> wanted) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::find(wanted.begin(), wanted.end(), word) != wanted.end();
  });
}

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

}  // namespace

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool hump =
        i > 0 && std::isupper(c) && std::islower(static_cast<unsigned char>(name[i - 1]));
    if (!std::isalnum(c) || hump) words.emplace_back();
    if (std::isalnum(c)) words.back().push_back(lower(name[i]));
  }
  return words;
}

std::string other_side(const std::string& name) {
  static const std::vector<std::array<std::string, 2>> swaps = {
      {"left", "right"}, {"l", "r"},   {"fl", "fr"}, {"rl", "rr"},
      {"hl", "hr"},      {"bl", "br"}, {"lf", "rf"}, {"lh", "rh"}};
  std::string other;
  for (std::string word : words_of(name)) {
    for (const auto& [left, right] : swaps) {
      if (word != left && word != right) continue;
      word = word == left ? right : left;
      break;
    }
    other += (other.empty() ? "" : "_") + word;
  }
  return other;
}

int end_of_name(const std::string& name) {
  const std::vector<std::string> words = words_of(name);
  if (any_of(words, {"front", "fore", "fl", "fr", "lf", "rf"})) return 1;
  if (any_of(words, {"rear", "back", "hind", "rl", "rr", "hl", "hr", "bl", "br", "lh", "rh"}))
    return -1;
  return 0;
}

int side_of_name(const std::string& name) {
  const std::vector<std::string> words = words_of(name);
  if (any_of(words, {"left", "l", "fl", "rl", "hl", "bl", "lf", "lh"})) return 1;
  if (any_of(words, {"right", "r", "fr", "rr", "hr", "br", "rf", "rh"})) return -1;
  return 0;
}

}  // namespace jaculus::model
