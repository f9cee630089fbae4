#include "trajectory/mapped_channel.h"

#include <fmt/format.h>

#include <algorithm>

#include "jaculus/core/error.h"
#include "trajectory/channel_units.h"
#include "trajectory/line_reader.h"

namespace jaculus::trajectory {
namespace {

std::string column_text(const yaml::Node& node) {
  // A number is a column's place where the file has no header.
  std::string text = node.is_scalar() ? node.dump() : "";
  double number = 0.0;
  return parse_number(text, number) ? text : node.text();
}

MappedChannel read_mapped_channel(const std::string& name, const yaml::Node& node,
                                  const std::string& word) {
  const std::string words = word + "s";
  node.only(std::vector<std::string>{word, words, "unit", "scale", "offset"});
  MappedChannel channel;
  channel.channel = name;
  if (node.has(word) == node.has(words))
    throw node.error(fmt::format("allowed: one of {} and {}", word, words));

  if (const auto column = node.find(word)) channel.columns = {column_text(*column)};
  if (const auto columns = node.find(words))
    for (const yaml::Node& column : columns->items())
      channel.columns.push_back(column_text(column));
  if (channel.columns.empty())
    throw node.at(words).error(fmt::format("an empty list given; allowed: at least one {}", word));

  if (const auto scale = node.find("scale")) channel.scale = scale->number(dimension::none);
  if (const auto offset = node.find("offset")) channel.shift = offset->number(dimension::none);
  if (channel.scale == 0.0) throw node.at("scale").error("0 given; allowed: any other factor");

  const auto unit = node.find("unit");
  const ChannelUnit si = channel_unit({name, unit ? unit->text() : ""},
                                      fmt::format("{}:{}", node.file().string(), node.line()));
  channel.scale *= si.factor;
  channel.shift *= si.factor;
  channel.unit = si.si;
  channel.apart = apart_of(name, channel.unit, count_of(channel.columns));

  return channel;
}

}  // namespace

std::vector<MappedChannel> read_mapped_channels(const yaml::Node& node, const std::string& word) {
  std::vector<MappedChannel> channels;
  for (const auto& [name, channel] : node.entries())
    channels.push_back(read_mapped_channel(name, channel, word));
  for (MappedChannel& own : channels) {
    // What the map states itself is not worked out.
    const bool stated = std::any_of(channels.begin(), channels.end(),
                                    [&](const MappedChannel& c) { return c.channel == own.apart; });
    if (stated) own.apart.clear();
  }
  return channels;
}

}  // namespace jaculus::trajectory
