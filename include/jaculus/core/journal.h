#pragma once
// A durable list of finished tasks. Every record is on the disk before append() returns, so that a
// run that is killed at any moment goes on where it was. File, all integers little-endian as the
// machine writes them:
//   "jaculus-journal/1\n"  key_length:u64  key  check:u64          the key names the list of tasks
//   { index:u64  length:u64  payload  check:u64 } ...
//     one a finished task, in order of finishing
// check is the FNV-1a hash of everything since the last one. A tail that is cut short or doesn't
// match its check is what an interrupted write leaves; it is cut off on opening.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace jaculus {

/// 64-bit FNV-1a hash, to key runs and check records; not cryptographic.
std::uint64_t hash64(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325ULL);

/// What a journal holds.
struct JournalContent {
  bool has_header = false;  ///< false: empty, or cut short within its header
  std::string key;
  std::map<int, std::string> finished;  ///< payload by task index
  std::uint64_t good_bytes = 0;         ///< length of the part that is whole
  std::uint64_t torn_bytes = 0;         ///< length of the rest
};

/// Reads a journal; one that does not exist is empty. InputError on a file that is something else
/// or can't be read.
JournalContent read_journal(const std::filesystem::path& file);

/// Follows a journal that another process, maybe on another machine, is writing. It takes no lock.
class JournalTail {
 public:
  explicit JournalTail(std::filesystem::path file) : file_(std::move(file)) {}
  /// What has been added since the last call; a record that is not whole yet comes later.
  /// InputError where the journal has another key.
  std::map<int, std::string> take(std::string_view key);

 private:
  std::filesystem::path file_;
  std::uint64_t offset_ = 0;
};

/// How a journal is kept from two writers.
enum class JournalLock {
  file,        ///< by a lock, on this machine
  sole_writer  ///< by its name, that no other process takes: a cluster's disk may lack locks
};

/// An open journal, locked against other processes.
class Journal {
 public:
  /// Opens or creates. InputError where it belongs to another key, is in use, or can't be written.
  Journal(const std::filesystem::path& file, std::string_view key,
          JournalLock lock = JournalLock::file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// What was there on opening.
  [[nodiscard]] const JournalContent& content() const { return content_; }
  /// Adds a finished task and waits for the disk. InputError where that fails, as on a full one.
  void append(int index, std::string_view payload);
  /// For a forked child, which must not hold on to the lock.
  void close_in_child();

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  JournalContent content_;
};

}  // namespace jaculus
