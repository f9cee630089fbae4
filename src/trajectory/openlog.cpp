#include "jaculus/trajectory/openlog.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>

#include "jaculus/core/error.h"
#include "trajectory/channel_units.h"
#include "trajectory/open_input.h"

namespace jaculus::trajectory {
namespace {

/// A window over a stream of bytes that is read by blocks.
class Bytes {
 public:
  explicit Bytes(std::istream& stream) : stream_(stream) {}

  /// Whether `count` bytes are at hand from the present place.
  bool have(std::size_t count) {
    constexpr std::size_t kBlock = std::size_t{1} << 18;
    while (buffer_.size() - at_ < count && !ended_) {
      buffer_.erase(buffer_.begin(), buffer_.begin() + at_);
      at_ = 0;
      const std::size_t before = buffer_.size();
      buffer_.resize(before + kBlock);
      stream_.read(reinterpret_cast<char*>(buffer_.data()) + before, kBlock);
      const std::size_t got = stream_.gcount();
      buffer_.resize(before + got);
      ended_ = got < kBlock;
    }
    return buffer_.size() - at_ >= count;
  }
  [[nodiscard]] const std::uint8_t* data() const { return buffer_.data() + at_; }
  [[nodiscard]] std::size_t left() const { return buffer_.size() - at_; }
  [[nodiscard]] std::uint64_t place() const { return place_; }  ///< of data() in the file
  void advance(std::size_t count) {
    at_ += count;
    place_ += count;
  }

 private:
  std::istream& stream_;
  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  std::uint64_t place_ = 0;
  bool ended_ = false;
};

std::uint64_t raw_bits(const std::uint8_t* bytes, std::size_t count, bool big_endian) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) bits = bits << 8 | bytes[big_endian ? i : count - 1 - i];
  return bits;
}

double raw_value(const OpenLogField& field, const std::uint8_t* record, bool big_endian) {
  const std::uint64_t bits = raw_bits(record + field.offset, field.bytes, big_endian);
  if (field.kind == 'u') return static_cast<double>(bits);
  if (field.kind == 'f') {
    const std::uint32_t low = bits & 0xffffffffU;
    return field.bytes == 4 ? std::bit_cast<float>(low) : std::bit_cast<double>(bits);
  }

  const std::size_t unused = 64 - 8 * field.bytes;
  return static_cast<double>(std::bit_cast<std::int64_t>(bits << unused) >> unused);
}

bool checksum_holds(const OpenLogFormat& format, const std::uint8_t* record) {
  std::uint8_t sum = 0;
  for (std::size_t i = format.sync.size(); i + 1 < format.record_bytes; ++i)
    sum = (format.checksum == "sum8" ? sum + record[i] : sum ^ record[i]) & 0xff;
  return sum == record[format.record_bytes - 1];
}

constexpr double kRounding = 1e-9;  ///< of times, at the ends of a window [s]

class OpenLogReader {
 public:
  OpenLogReader(std::istream& stream, std::string name, const OpenLogFormat& format,
                const LogWindow* window)
      : bytes_(stream), name_(std::move(name)), format_(format), window_(window) {
    stream_.name = format.stream;
    stream_.rate_hz = format.rate_hz;
    for (const OpenLogField& field : format.fields) {
      channel_.push_back(-1);
      if (field.channel.empty() || field.channel == "time") continue;
      channel_.back() = stream_.channel(field.channel);
      if (channel_.back() < 0) {
        channel_.back() = count_of(stream_.channels);
        stream_.channels.push_back(field.channel);
        stream_.units.push_back(field.unit);
        shares_.push_back(0);
      }
      ++shares_[channel_.back()];
    }
    add_aparts();

    if (window_ == nullptr || window_->channel.empty()) return;
    passing_ = stream_.channel(window_->channel);
    if (passing_ >= 0) return;
    throw InputError(fmt::format("{}: there is no channel '{}' in this log{}", name_,
                                 window_->channel,
                                 yaml::did_you_mean(window_->channel, stream_.channels)));
  }

  Stream read(std::vector<std::string>& notes) {
    skip_header();

    while (!behind_ && bytes_.have(format_.record_bytes)) {
      const std::uint8_t* record = bytes_.data();
      const bool in_step = std::equal(format_.sync.begin(), format_.sync.end(), record);
      if (!in_step || (!format_.checksum.empty() && !checksum_holds(format_, record))) {
        if (in_step) ++bad_sums_;
        resynchronise();
        continue;
      }
      take(record);
      bytes_.advance(format_.record_bytes);
    }

    if (records_ == 0)
      throw InputError(fmt::format(
          "{}: no record of {} bytes is in this log; allowed: a log that the description fits",
          name_, format_.record_bytes));
    if (window_ != nullptr) check_window();
    report(notes);
    return finish();
  }

 private:
  /// Channels of what two fields of one position differ by.
  void add_aparts() {
    sides_.resize(format_.fields.size());
    const int means = count_of(stream_.channels);
    for (int c = 0; c < means; ++c) {
      const std::string apart = apart_of(stream_.channels[c], stream_.units[c], shares_[c]);
      if (apart.empty() || stream_.channel(apart) >= 0) continue;
      double sign = 1.0;
      for (std::size_t i = 0; i < channel_.size(); ++i) {
        if (channel_[i] != c) continue;
        sides_[i] = {count_of(stream_.channels), sign};
        sign = -1.0;
      }
      stream_.channels.push_back(apart);
      stream_.units.push_back(stream_.units[c]);
    }
  }

  void skip_header() {
    std::size_t left = format_.header_bytes;
    while (left > 0 && bytes_.have(1)) {
      const std::size_t step = std::min(left, bytes_.left());
      bytes_.advance(step);
      left -= step;
    }
    if (left > 0)
      throw InputError(
          fmt::format("{}: ends within its header of {} bytes", name_, format_.header_bytes));

    const auto& until = format_.header_until;
    if (until.empty()) return;
    for (; bytes_.have(until.size()); bytes_.advance(1)) {
      if (!std::equal(until.begin(), until.end(), bytes_.data())) continue;
      bytes_.advance(until.size());
      return;
    }
    throw InputError(fmt::format("{}: the bytes that end the header are nowhere in it", name_));
  }

  /// To the next place where a record may begin. Without sync there is none but the next record.
  void resynchronise() {
    if (format_.sync.empty()) {
      bytes_.advance(format_.record_bytes);
      return;
    }
    do {
      bytes_.advance(1);
      ++skipped_;
    } while (bytes_.have(format_.sync.size()) &&
             !std::equal(format_.sync.begin(), format_.sync.end(), bytes_.data()));
  }

  void take(const std::uint8_t* record) {
    const auto kept = std::ssize(times_);
    // rows stay, so that this is a reallocation in place where there is room
    if (kept == stream_.values.cols()) {
      const Eigen::Index more = std::max<Eigen::Index>(1024, kept + kept / 2);
      stream_.values.conservativeResize(stream_.channels.size(), more);
    }

    auto values = stream_.values.col(kept);
    values.setZero();

    for (std::size_t i = 0; i < format_.fields.size(); ++i) {
      const OpenLogField& field = format_.fields[i];
      if (field.channel.empty()) continue;
      const double raw = raw_value(field, record, format_.big_endian);
      if (channel_[i] < 0) {
        add_time(field, raw);
        continue;
      }
      const double value = field.scale * raw + field.shift;
      // What no number is (a sensor's fault written as NaN) is a gap.
      const double known = std::isfinite(value) ? value : kNaN;
      values[channel_[i]] += known / shares_[channel_[i]];
      if (sides_[i].channel >= 0) values[sides_[i].channel] += sides_[i].sign * known;
    }

    ++records_;
    if (window_ != nullptr) keep_window();
  }

  /// Finds time zero and lets go of what lies outside the window.
  void keep_window() {
    const double time = times_.back();
    const auto last = std::ssize(times_) - 1;
    if (std::isnan(zero_)) {
      if (passing_ < 0) {
        zero_ = window_->zero.value_or(time);
      } else if (stream_.values(passing_, last) > window_->above) {
        zero_ = time;
        drop_before(std::min(time, zero_ + window_->cut.lower));
      } else {
        drop_before(time + std::min(0.0, window_->cut.lower), times_.size() / 2);
        return;
      }
    }
    behind_ = time > zero_ + window_->cut.upper + kRounding;
    if (behind_ || time < zero_ + window_->cut.lower - kRounding) times_.pop_back();
  }

  /// Forgets records before a time, unless they are fewer than `least`.
  void drop_before(double time, std::size_t least = 1) {
    const auto first = std::lower_bound(times_.begin(), times_.end(), time - kRounding);
    const std::size_t count = first - times_.begin();
    if (count < std::max<std::size_t>(least, 1)) return;
    times_.erase(times_.begin(), first);
    double* data = stream_.values.data();
    const std::ptrdiff_t rows = stream_.values.rows();
    std::copy(data + count * rows, data + (count + std::ssize(times_)) * rows, data);
  }

  void check_window() const {
    if (std::isnan(zero_))
      throw InputError(fmt::format("{}: {} never passes {}; allowed: another start", name_,
                                   window_->channel, window_->above));
    if (times_.empty())
      throw InputError(
          fmt::format("{}: no sample lies within the cut, {} to {} s about {:.6g} s of the log",
                      name_, window_->cut.lower, window_->cut.upper, zero_));
  }

  void add_time(const OpenLogField& field, double raw) {
    const double range = std::exp2(8.0 * static_cast<double>(field.bytes));
    if (field.kind == 'u' && records_ > 0 && raw < last_raw_ && last_raw_ - raw > 0.5 * range) {
      wraps_ += range;
      ++wrapped_;
    }
    last_raw_ = raw;

    const double time = field.scale * (raw + wraps_) + field.shift;
    const auto fault = [&](const std::string& what) {
      return InputError(
          fmt::format("{}: byte {}, record {}: {}", name_, bytes_.place(), records_ + 1, what));
    };
    if (!std::isfinite(time)) throw fault("time is no number");
    if (records_ > 0 && !(time > last_time_))
      throw fault(
          fmt::format("time {:.10g} s follows {:.10g} s; allowed: rising times", time, last_time_));
    last_time_ = time;
    times_.push_back(time);
  }

  void report(std::vector<std::string>& notes) const {
    notes.push_back(
        fmt::format("{} records of {} bytes were read", records_, format_.record_bytes));

    if (passing_ >= 0)
      notes.push_back(fmt::format("time zero where {} first passes {}: {:.6g} s of the file",
                                  window_->channel, window_->above, zero_));

    if (behind_)
      notes.push_back(fmt::format("reading ended behind the cut, at byte {}", bytes_.place()));
    if (skipped_ > 0)
      notes.push_back(fmt::format("{} bytes belong to no record and were passed over", skipped_));
    if (bad_sums_ > 0)
      notes.push_back(fmt::format("{} records have a wrong checksum and were dropped", bad_sums_));
    if (wrapped_ > 0)
      notes.push_back(fmt::format("the clock wrapped {} times and was unwrapped", wrapped_));

    if (bytes_.left() > 0 && !behind_)
      notes.push_back(
          fmt::format("the last record is cut short: {} of {} bytes are there and were dropped",
                      bytes_.left(), format_.record_bytes));

    for (std::size_t c = 0; c < shares_.size(); ++c)
      if (shares_[c] > 1)
        notes.push_back(
            fmt::format("{} is the mean of {} fields", stream_.channels[c], shares_[c]));
    for (std::size_t c = shares_.size(); c < stream_.channels.size(); ++c)
      notes.push_back(
          fmt::format("{} is the first of its fields less the second", stream_.channels[c]));
  }

  Stream finish() {
    const auto samples = std::ssize(times_);
    stream_.time = Eigen::Map<const Vector>(times_.data(), samples);
    if (window_ != nullptr) stream_.time.array() -= zero_;
    stream_.values.conservativeResize(Eigen::NoChange, samples);
    return std::move(stream_);
  }

  Bytes bytes_;
  std::string name_;
  const OpenLogFormat& format_;
  Stream stream_;
  std::vector<int> channel_;  ///< of each field, -1 where it is none or time
  std::vector<int> shares_;   ///< fields of each channel that is their mean
  /// A field's part in what two sides differ by; channel -1 without.
  struct Side {
    int channel = -1;
    double sign = 1.0;
  };
  std::vector<Side> sides_;  ///< of each field
  const LogWindow* window_;
  int passing_ = -1;     ///< channel that tells time zero
  double zero_ = kNaN;   ///< once known [s of the log]
  bool behind_ = false;  ///< the window lies behind
  /// of the records that are kept; their values are the first columns of stream_.values
  std::vector<double> times_;
  double last_raw_ = 0.0, last_time_ = 0.0, wraps_ = 0.0;
  std::uint64_t skipped_ = 0, records_ = 0;
  int bad_sums_ = 0, wrapped_ = 0;
};

}  // namespace

Stream read_openlog(std::istream& stream, const std::string& name, const OpenLogFormat& format,
                    std::vector<std::string>& notes) {
  return OpenLogReader(stream, name, format, nullptr).read(notes);
}

Stream read_openlog(const std::filesystem::path& file, const OpenLogFormat& format,
                    std::vector<std::string>& notes) {
  std::ifstream stream = open_input(file, "a binary log");
  return read_openlog(stream, file.string(), format, notes);
}

Stream read_openlog(std::istream& stream, const std::string& name, const OpenLogFormat& format,
                    const LogWindow& window, std::vector<std::string>& notes) {
  return OpenLogReader(stream, name, format, &window).read(notes);
}

Stream read_openlog(const std::filesystem::path& file, const OpenLogFormat& format,
                    const LogWindow& window, std::vector<std::string>& notes) {
  std::ifstream stream = open_input(file, "a binary log");
  return read_openlog(stream, file.string(), format, window, notes);
}

}  // namespace jaculus::trajectory
