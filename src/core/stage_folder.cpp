#include "core/stage_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "jaculus/core/error.h"
#include "jaculus/core/types.h"

namespace jaculus::detail {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "jaculus-jobs/1";

/// Whole or not at all, also for a reader on another machine.
void write_whole(const fs::path& file, const std::string& text) {
  const fs::path aside = file.string() + ".new";
  std::ofstream stream(aside, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw InputError(fmt::format("{}: can't be written", file.string()));
  fs::rename(aside, file);
}

std::string read_whole(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Json read_json(const fs::path& file) {
  try {
    return Json::parse(read_whole(file));
  } catch (const Json::exception&) {
    throw InputError(
        fmt::format("{}: not readable as JSON; allowed: as jaculus wrote it", file.string()));
  }
}

int number_in(const std::string& text) {
  int value = -1;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || value < 0)
    throw InputError(fmt::format("'{}': no list of indices; allowed: as in 0-24,30", text));
  return value;
}

}  // namespace

std::string ranges_text(const std::vector<int>& indices) {
  std::string text;
  for (std::size_t first = 0, last = 0; first < indices.size(); first = last + 1) {
    last = first;
    while (last + 1 < indices.size() && indices[last + 1] == indices[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", indices[first]);
    if (last > first) text += fmt::format("-{}", indices[last]);
  }
  return text;
}

std::vector<int> ranges_of(const std::string& text) {
  std::vector<int> indices;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    const std::size_t dash = part.find('-');
    const int first = number_in(part.substr(0, dash));
    const int last = dash == std::string::npos ? first : number_in(part.substr(dash + 1));
    for (int i = first; i <= last; ++i) indices.push_back(i);
  }
  return indices;
}

std::string Element::name() const { return fmt::format("{}.{}", round, chunk); }

std::string Element::worker(int restarts) const { return fmt::format("{}.{}", name(), restarts); }

void StageFolder::open(const std::string& stage, int count, const std::string& key) {
  stage_ = stage;
  key_ = key;
  count_ = count;
  if (fs::exists(path_ / "stage.json")) {
    StageFolder there(path_);
    there.read();
    if (there.key_ != key) {
      throw InputError(
          path_.string() +
          ": belongs to another list of tasks (its inputs differ); remove it to begin anew");
    }
    cost_s_ = there.cost_s_;
    asked_ = there.asked_;
    return;
  }

  std::error_code code;
  for (const char* folder : {"begun", "done", "failed", "lost", "log"}) {
    fs::create_directories(path_ / folder, code);
    if (code)
      throw InputError(fmt::format("{}: can't be made: {}", path_.string(), code.message()));
  }
  fs::permissions(path_, fs::perms::owner_all, code);  // labels of blinded cases may be in it
  write();
}

void StageFolder::read() {
  const Json json = read_json(path_ / "stage.json");
  if (json.value("format", "") != kFormat)
    throw InputError(fmt::format("{}: not of format {}", (path_ / "stage.json").string(), kFormat));
  stage_ = json.at("stage").get<std::string>();
  count_ = json.at("tasks").get<int>();
  key_ = json.at("key").get<std::string>();
  if (json.contains("cost_s")) cost_s_ = json["cost_s"].get<double>();
  if (json.contains("asked")) asked_ = json["asked"].get<int>();
  if (json.contains("finished")) finished_ = json["finished"].get<int>();
}

void StageFolder::write() const {
  Json json{{"format", kFormat}, {"stage", stage_}, {"tasks", count_}, {"key", key_}};
  if (cost_s_) json["cost_s"] = *cost_s_;
  if (asked_) json["asked"] = *asked_;
  if (finished_) json["finished"] = *finished_;
  write_whole(path_ / "stage.json", json.dump(1) + "\n");
}

void StageFolder::set_cost(double cost_s) {
  cost_s_ = cost_s;
  write();
}

void StageFolder::set_asked(int asked) {
  if (asked == this->asked()) return;
  asked_ = asked;
  write();
}

void StageFolder::set_finished(int finished) {
  finished_ = finished;
  write();
}

int StageFolder::rounds() const {
  int number = 0;
  while (fs::exists(path_ / fmt::format("round_{}.json", number + 1))) ++number;
  return number;
}

Round StageFolder::round(int number) const {
  Round round;
  const Json json = read_json(path_ / fmt::format("round_{}.json", number));
  for (const Json& chunk : json.at("chunks"))
    round.chunks.push_back(ranges_of(chunk.get<std::string>()));
  round.job = read_whole(path_ / fmt::format("round_{}.id", number));
  return round;
}

void StageFolder::write_round(int number, const std::vector<std::vector<int>>& chunks) const {
  Json json{{"chunks", Json::array()}};
  for (const std::vector<int>& chunk : chunks) json["chunks"].push_back(ranges_text(chunk));
  write_whole(path_ / fmt::format("round_{}.json", number), json.dump(1) + "\n");
}

void StageFolder::write_job(int number, const std::string& job) const {
  write_whole(path_ / fmt::format("round_{}.id", number), job);
}

std::map<int, std::string> StageFolder::fresh(const char* folder) {
  std::map<int, std::string> records;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_ / folder)) {
    JournalTail& tail = tails_.try_emplace(entry.path(), entry.path()).first->second;
    records.merge(tail.take(key_));
  }
  return records;
}

std::vector<int> StageFolder::begun(const Element& element) const {
  std::set<int> indices;
  for (const std::string& name : workers("begun", element)) {
    std::ifstream stream(file("begun", name));
    for (int index = 0; stream >> index;) indices.insert(index);
  }
  return {indices.begin(), indices.end()};
}

bool StageFolder::superseded(const Element& element, int restarts) const {
  return fs::exists(file("begun", element.worker(restarts + 1))) ||
         fs::exists(file("lost", element.name()));
}

void StageFolder::give_up(const Element& element) const {
  std::ofstream(file("lost", element.name())).flush();
}

std::vector<std::string> StageFolder::workers(const char* folder, const Element& element) const {
  std::vector<std::string> names;
  const std::string prefix = element.name() + ".";
  for (const fs::directory_entry& entry : fs::directory_iterator(path_ / folder)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(prefix)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string StageFolder::last_words(const Element& element) const {
  std::istringstream stream(read_whole(file("log", element.name() + ".txt")));
  std::string last;
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) last = line;
  return last;
}

std::vector<fs::path> stage_folders(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code code;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, code))
    if (fs::exists(entry.path() / "stage.json")) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    return fs::last_write_time(a / "log") < fs::last_write_time(b / "log");
  });
  return folders;
}

}  // namespace jaculus::detail
