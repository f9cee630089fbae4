#include "jaculus/core/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "jaculus/core/error.h"

namespace jaculus {
namespace {

constexpr std::string_view kMagic = "jaculus-journal/1\n";

void put(std::string& bytes, std::uint64_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Takes one number off the front, or nothing where too little is left.
std::optional<std::uint64_t> take_number(std::string_view& rest) {
  std::uint64_t value = 0;
  if (rest.size() < sizeof value) return std::nullopt;
  std::memcpy(&value, rest.data(), sizeof value);
  rest.remove_prefix(sizeof value);
  return value;
}

std::optional<std::string_view> take(std::string_view& rest, std::uint64_t size) {
  if (rest.size() < size) return std::nullopt;
  const std::string_view head = rest.substr(0, size);
  rest.remove_prefix(size);
  return head;
}

/// Takes "length, that many bytes, check" off the front; `start` is where the checked part begins.
std::optional<std::string_view> take_checked(std::string_view& rest, const char* start) {
  const auto length = take_number(rest);
  const auto body = length ? take(rest, *length) : std::nullopt;
  if (!body) return std::nullopt;
  const std::string_view checked(start, rest.data() - start);
  const auto check = take_number(rest);
  if (!check || *check != hash64(checked)) return std::nullopt;
  return body;
}

void write_all(int descriptor, const std::filesystem::path& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      throw InputError(file.string() + ": can't be written: " + std::strerror(errno));
    bytes.remove_prefix(written);
  }
  if (fdatasync(descriptor) != 0)
    throw InputError(file.string() + ": can't be written: " + std::strerror(errno));
}

/// A new file is only durable once its folder is.
void sync_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder =
      file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // some file systems refuse; the records are synced all the same
  fsync(descriptor);
  close(descriptor);
}

/// Takes whole records off the front of `rest`; returns how many bytes they are.
std::uint64_t take_records(std::string_view rest, std::map<int, std::string>& finished) {
  std::uint64_t taken = 0;
  const std::size_t size = rest.size();
  for (;;) {
    const char* start = rest.data();
    const auto index = take_number(rest);
    const auto payload = index ? take_checked(rest, start) : std::nullopt;
    if (!payload) return taken;
    finished.emplace(static_cast<int>(*index), *payload);
    taken = size - rest.size();
  }
}

/// A killed run's children may hold the lock for a moment longer than it lived. A disk that has no
/// locks, as NFS may be mounted, keeps nobody out.
bool lock_patiently(int descriptor) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return true;
    if (errno == ENOLCK || errno == EOPNOTSUPP || errno == ENOSYS) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

}  // namespace

std::uint64_t hash64(std::string_view bytes, std::uint64_t state) {
  for (const char c : bytes) state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return state;
}

JournalContent read_journal(const std::filesystem::path& file) {
  JournalContent content;
  if (!std::filesystem::exists(file)) return content;

  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)),
                          std::istreambuf_iterator<char>());
  if (!stream) throw InputError(file.string() + ": can't be read");

  std::string_view rest = bytes;
  const std::string_view magic = rest.substr(0, kMagic.size());
  if (magic != kMagic.substr(0, magic.size())) {
    throw InputError(file.string() +
                     ": not a journal of finished tasks; give the name of one, or of a new file");
  }

  rest.remove_prefix(magic.size());
  const auto key = take_checked(rest, bytes.data());
  if (key) {
    content.has_header = true;
    content.key = *key;
    content.good_bytes = bytes.size() - rest.size();
    content.good_bytes += take_records(rest, content.finished);
  }

  content.torn_bytes = bytes.size() - content.good_bytes;
  return content;
}

std::map<int, std::string> JournalTail::take(std::string_view key) {
  std::map<int, std::string> fresh;
  if (offset_ == 0) {
    JournalContent content = read_journal(file_);
    if (!content.has_header) return fresh;
    if (content.key != key)
      throw InputError(file_.string() + ": belongs to another list of tasks (its inputs differ)");
    offset_ = content.good_bytes;
    return std::move(content.finished);
  }

  std::ifstream stream(file_, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(offset_));
  const std::string bytes((std::istreambuf_iterator<char>(stream)),
                          std::istreambuf_iterator<char>());
  offset_ += take_records(bytes, fresh);
  return fresh;
}

Journal::Journal(const std::filesystem::path& file, std::string_view key, JournalLock lock)
    : file_(file) {
  descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0)
    throw InputError(file.string() + ": can't be written: " + std::strerror(errno));
  try {
    if (lock == JournalLock::file && !lock_patiently(descriptor_))
      throw InputError(file.string() + ": in use by another run; wait for it, or end it");
    content_ = read_journal(file);

    if (content_.has_header && content_.key != key) {
      throw InputError(
          file.string() +
          ": belongs to another list of tasks (its inputs differ); remove it to begin anew");
    }

    if (ftruncate(descriptor_, static_cast<off_t>(content_.good_bytes)) != 0 ||
        lseek(descriptor_, 0, SEEK_END) < 0) {
      throw InputError(file.string() + ": can't be written: " + std::strerror(errno));
    }

    if (!content_.has_header) {
      std::string header(kMagic);
      put(header, key.size());
      header += key;
      put(header, hash64(header));
      write_all(descriptor_, file_, header);
      sync_folder(file);
    }
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

Journal::~Journal() {
  if (descriptor_ >= 0) close(descriptor_);
}

void Journal::append(int index, std::string_view payload) {
  std::string record;
  record.reserve(payload.size() + 3 * sizeof(std::uint64_t));
  put(record, static_cast<std::uint64_t>(index));
  put(record, payload.size());
  record += payload;
  put(record, hash64(record));
  write_all(descriptor_, file_, record);
}

void Journal::close_in_child() {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
}

}  // namespace jaculus
