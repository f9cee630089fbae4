#pragma once
// Binary logs of fixed-length records, as the Minitaur's OpenLog writes them, read by a description
// in YAML:
//
//   format: jaculus-openlog/1
//   stream: joints                    # name of the dataset's stream
//   rate_hz: 91                       # optional, as stated
//   byte_order: little                # or big
//   header: {bytes: 128}              # before the first record; or {until: [0x0A, 0x0A]}: through
//                                     # these bytes; default none
//   sync: [0xAA, 0x55]                # bytes that open every record; default none
//   record_bytes: 64                  # whole record, sync and checksum among them; default: what
//                                     # the fields take
//   checksum: {kind: sum8}            # last byte: sum (sum8) or exclusive or (xor8) of the bytes
//                                     # between sync and it
//   fields:                           # in order; `skip: n` passes over n bytes
//     - {name: t, type: uint32, scale: 1e-6, unit: s, channel: time}
//     - {name: mot0, type: float32, unit: rad, scale: -1, offset: 1.5708, channel: front_a}
//     - {name: mot4, type: float32, unit: rad, channel: front_a}    # two of one channel: mean
//     - {skip: 2}
//     - {name: mode, type: uint8}                                   # no channel: not kept
//
// Of two fields that make up a joint's position the first less the second stands beside their mean,
// as `front_a_apart`.
//
// value in `unit` = scale * raw + offset; then to SI. Types: int8 ... int64, uint8 ... uint64,
// float32, float64. A time of an unsigned type that wraps is unwrapped. Where sync is stated, bytes
// that belong to no record are passed over and counted.

#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

struct OpenLogField {
  std::string name;
  char kind = 'u';         ///< 'i' signed, 'u' unsigned, 'f' floating
  std::size_t offset = 0;  ///< in the record [bytes]
  std::size_t bytes = 0;   ///< 1, 2, 4 or 8
  double scale = 1.0;      ///< SI = scale * raw + shift
  double shift = 0.0;      ///< [SI]
  std::string channel;     ///< empty: not kept
  std::string unit;        ///< SI unit of the channel
};

struct OpenLogFormat {
  std::string stream = kJointStream;
  double rate_hz = kNaN;
  bool big_endian = false;
  std::size_t header_bytes = 0;
  std::vector<std::uint8_t> header_until;
  std::vector<std::uint8_t> sync;
  std::size_t record_bytes = 0;
  std::string checksum;  ///< "", "sum8", "xor8"
  std::vector<OpenLogField> fields;
};

/// Which part of a log is kept, so that a long one is never held as a whole.
struct LogWindow {
  std::optional<double> zero;  ///< time zero [s of the log]; nothing: its first record
  std::string channel;  ///< or where this channel first passes `above`; empty: not by a channel
  double above = 0.0;   ///< [SI unit of the channel]
  Bounds cut;           ///< what is kept, both ends included [s about time zero]
};

/// Checks a description. Faults: InputError with the node's place.
OpenLogFormat read_openlog_format(const yaml::Node& description);

/// Reads a log in one pass. A record out of step (no sync), or of a wrong checksum, is passed over
/// and counted in `notes`; so is a tail that is cut short. No record at all, or time that runs
/// backwards otherwise than by wrapping: InputError with the byte's place.
Stream read_openlog(std::istream& stream, const std::string& name, const OpenLogFormat& format,
                    std::vector<std::string>& notes);
Stream read_openlog(const std::filesystem::path& file, const OpenLogFormat& format,
                    std::vector<std::string>& notes);

/// The window of a log, times counted from its zero; reading stops behind the window. Besides the
/// faults above: no such channel, a channel that never passes, no record within the cut.
Stream read_openlog(std::istream& stream, const std::string& name, const OpenLogFormat& format,
                    const LogWindow& window, std::vector<std::string>& notes);
Stream read_openlog(const std::filesystem::path& file, const OpenLogFormat& format,
                    const LogWindow& window, std::vector<std::string>& notes);

}  // namespace jaculus::trajectory
