#include <fmt/format.h>

#include <map>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/trajectory/openlog.h"
#include "trajectory/channel_units.h"

namespace jaculus::trajectory {
namespace {

constexpr int kMostBytes = 1 << 16;

struct Type {
  char kind;
  std::size_t bytes;
};

const std::map<std::string, Type>& types() {
  static const std::map<std::string, Type> table = {
      {"int8", {'i', 1}},    {"int16", {'i', 2}},   {"int32", {'i', 4}},  {"int64", {'i', 8}},
      {"uint8", {'u', 1}},   {"uint16", {'u', 2}},  {"uint32", {'u', 4}}, {"uint64", {'u', 8}},
      {"float32", {'f', 4}}, {"float64", {'f', 8}},
  };
  return table;
}

std::vector<std::uint8_t> read_bytes(const yaml::Node& node) {
  std::vector<std::uint8_t> bytes;
  for (const yaml::Node& item : node.items()) {
    // Hexadecimal is how bytes are written; the reader's numbers are decimal.
    const std::string text = item.is_scalar() ? item.dump() : "";
    std::size_t used = 0;
    int value = -1;
    try {
      value = std::stoi(text, &used, text.starts_with("0x") || text.starts_with("0X") ? 16 : 10);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != text.size() || value < 0 || value > 255)
      throw item.error(fmt::format("{} given; allowed: a byte, 0 to 255 or 0x00 to 0xFF", text));
    bytes.push_back(static_cast<std::uint8_t>(value));
  }
  if (bytes.empty() || bytes.size() > 64) throw node.error("allowed: a list of 1 to 64 bytes");
  return bytes;
}

OpenLogField read_field(const yaml::Node& node) {
  node.only({"name", "type", "scale", "offset", "unit", "channel"});
  OpenLogField field;
  field.name = node.at("name").text();

  std::vector<std::string> names;
  for (const auto& [name, type] : types()) names.push_back(name);
  const Type type = types().at(node.at("type").choice(names));
  field.kind = type.kind;
  field.bytes = type.bytes;

  if (const auto scale = node.find("scale")) field.scale = scale->number(dimension::none);
  if (const auto offset = node.find("offset")) field.shift = offset->number(dimension::none);
  if (field.scale == 0.0) throw node.at("scale").error("0 given; allowed: any other factor");

  if (const auto channel = node.find("channel")) {
    field.channel = channel->text();
    const auto unit = node.find("unit");
    const Column column{field.channel, unit ? (unit->is_scalar() ? unit->text() : "") : ""};
    const ChannelUnit si =
        channel_unit(column, fmt::format("{}:{}", node.file().string(), node.line()));
    field.scale *= si.factor;
    field.shift *= si.factor;
    field.unit = si.si;
  }

  return field;
}

void read_fields(const yaml::Node& node, OpenLogFormat& format) {
  std::size_t at = format.sync.size();
  std::map<std::string, std::string> units;
  int times = 0;

  for (const yaml::Node& item : node.items()) {
    if (item.is_map() && item.has("skip")) {
      item.only({"skip"});
      at += item.at("skip").integer(1, kMostBytes);
      continue;
    }

    OpenLogField field = read_field(item);
    field.offset = at;
    at += field.bytes;
    if (field.channel == "time") ++times;
    if (!field.channel.empty()) {
      const auto known = units.emplace(field.channel, field.unit).first;
      if (known->second != field.unit)
        throw item.error(fmt::format("channel '{}' is in {} here and in {} before", field.channel,
                                     field.unit, known->second));
    }
    format.fields.push_back(std::move(field));
  }

  if (times != 1)
    throw node.error(fmt::format("{} fields are of the channel 'time'; allowed: one", times));
  if (units.size() < 2) throw node.error("no field but time has a channel; allowed: at least one");

  if (!format.checksum.empty()) ++at;
  if (at > kMostBytes)
    throw node.error(fmt::format("a record of {} bytes; allowed: at most {}", at, kMostBytes));
  if (format.record_bytes != 0 && format.record_bytes < at)
    throw node.error(
        fmt::format("the fields, sync and checksum take {} bytes; record_bytes says {}", at,
                    format.record_bytes));
  if (format.record_bytes == 0) format.record_bytes = at;
}

}  // namespace

OpenLogFormat read_openlog_format(const yaml::Node& node) {
  node.only({"format", "stream", "rate_hz", "byte_order", "header", "sync", "record_bytes",
             "checksum", "fields"});
  (void)node.at("format").choice({"jaculus-openlog/1"});
  OpenLogFormat format;

  if (const auto stream = node.find("stream")) format.stream = stream->text();
  if (const auto rate = node.find("rate_hz"))
    format.rate_hz = rate->number(dimension::frequency, {1e-12, kInfinity});
  if (const auto order = node.find("byte_order"))
    format.big_endian = order->choice({"little", "big"}) == "big";

  if (const auto header = node.find("header")) {
    header->only({"bytes", "until"});
    if (header->has("bytes") == header->has("until"))
      throw header->error("allowed: one of bytes and until");
    if (const auto bytes = header->find("bytes")) format.header_bytes = bytes->integer(0, 1 << 30);
    if (const auto until = header->find("until")) format.header_until = read_bytes(*until);
  }

  if (const auto sync = node.find("sync")) format.sync = read_bytes(*sync);
  if (const auto bytes = node.find("record_bytes"))
    format.record_bytes = bytes->integer(1, kMostBytes);
  if (const auto checksum = node.find("checksum")) {
    checksum->only({"kind"});
    format.checksum = checksum->at("kind").choice({"sum8", "xor8"});
  }

  read_fields(node.at("fields"), format);
  return format;
}

}  // namespace jaculus::trajectory
