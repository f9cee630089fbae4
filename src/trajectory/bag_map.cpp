#include "jaculus/trajectory/bag_map.h"

#include <set>

#include "jaculus/core/error.h"
#include "trajectory/mapped_channel.h"

namespace jaculus::trajectory {
namespace {

BagTopic read_topic(const std::string& name, const yaml::Node& node) {
  node.only({"stream", "rate_hz", "stamp", "joints", "forward", "rest", "channels"});
  BagTopic topic;
  topic.topic = name;
  if (const auto stream = node.find("stream")) topic.stream = stream->text();
  if (const auto rate = node.find("rate_hz"))
    topic.rate_hz = rate->number(dimension::frequency, {1e-12, kInfinity});
  if (const auto stamp = node.find("stamp"))
    topic.stamp = bag_stamps().find(stamp->choice(bag_stamps().names()));

  if (const auto joints = node.find("joints"))
    for (const auto& [theirs, ours] : joints->entries()) topic.joints[theirs] = ours.text();
  if (const auto forward = node.find("forward"))
    topic.forward = mocap_forwards().find(forward->choice(mocap_forwards().names()));
  if (const auto rest = node.find("rest"))
    topic.rest = rest->number(dimension::time, {0.0, kInfinity});

  if (const auto channels = node.find("channels")) {
    topic.channels = read_mapped_channels(*channels, "field");
    if (topic.channels.empty())
      throw channels->error("an empty map given; allowed: at least one channel");
  }

  if (!topic.channels.empty() && (!topic.joints.empty() || topic.forward || topic.rest))
    throw node.error("allowed: `channels`, or `joints`, `forward` and `rest` of a known type");
  return topic;
}

}  // namespace

const NameTable<BagStamp>& bag_stamps() {
  static const NameTable<BagStamp> table({{BagStamp::header, "header"}, {BagStamp::log, "log"}});
  return table;
}

std::vector<BagTopic> read_bag_map(const yaml::Node& node) {
  yaml::refuse_other_kind(node, "jaculus-bag/1");
  node.only({"format", "topics"});
  (void)node.at("format").choice({"jaculus-bag/1"});

  std::vector<BagTopic> topics;
  std::set<std::string> streams;
  for (const auto& [name, entry] : node.at("topics").entries()) {
    topics.push_back(read_topic(name, entry));
    const std::string& stream = topics.back().stream;
    if (!stream.empty() && !streams.insert(stream).second)
      throw entry.at("stream").error("another topic has it; allowed: a stream of its own");
  }

  if (topics.empty()) throw node.at("topics").error("allowed: at least one topic");
  return topics;
}

}  // namespace jaculus::trajectory
