#include "diagnosis/read_tolerances.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "jaculus/core/error.h"
#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"

namespace jaculus::diagnosis {
namespace {

/// "x (mm), pitch (deg)": every name once.
std::string allowed_channels(const Observations& observations) {
  std::vector<std::string> names;
  for (const ObservedDataset& observed : observations.datasets) {
    for (const Channel& channel : observed.channels) {
      const std::string name = fmt::format("{} ({})", channel.name, shown_unit(channel.unit).unit);
      if (index_of(names, name) < 0) names.push_back(name);
    }
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

[[noreturn]] void refuse_channel(const std::string& place, const std::string& name,
                                 const Observations& observations) {
  std::vector<std::string> names;
  for (const ObservedDataset& observed : observations.datasets)
    for (const Channel& channel : observed.channels) names.push_back(channel.name);
  throw InputError(fmt::format("{}: no channel '{}' is judged here{}; allowed: {}", place, name,
                               yaml::did_you_mean(name, names), allowed_channels(observations)));
}

double positive_quantity(const std::string& place, const std::string& text,
                         const Channel& channel) {
  const Dimension dimension = unit_dimension(channel.unit);
  const std::vector<OwnUnit> plain = {{"SI", 1.0, dimension}};  // a program's number of any channel
  const OwnUnits own = [&]() -> const std::vector<OwnUnit>& { return plain; };
  double value = kNaN;
  try {
    value = parse_quantity(text, dimension, &own);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}", place, e.what()));
  }
  if (value > 0.0) return value;
  throw InputError(fmt::format("{}: '{}' given; allowed: more than 0 {}", place, text,
                               shown_unit(channel.unit).unit));
}

}  // namespace

std::string channel_key(const Observations& observations, int dataset, int channel) {
  const ObservedDataset& observed = observations.datasets[dataset];
  const Channel& own = observed.channels[channel];
  const std::string prefix = observations.datasets.size() > 1 ? observed.name() + "." : "";
  return prefix + own.stream + "." + own.name;
}

Tolerances read_tolerances(const std::vector<std::string>& texts,
                           const Observations& observations) {
  Tolerances tolerances;
  if (observations.datasets.empty()) return tolerances;  // the diagnosis says why
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const std::string place = fmt::format("--tolerance {}", text);
    if (equals == std::string::npos)
      throw InputError(fmt::format("{}: no '=' given; allowed: CHANNEL=QUANTITY of {}", place,
                                   allowed_channels(observations)));
    const std::string name = text.substr(0, equals), quantity = text.substr(equals + 1);

    bool found = false;
    for (int d = 0; d < count_of(observations.datasets); ++d) {
      for (int c = 0; c < count_of(observations.datasets[d].channels); ++c) {
        const Channel& channel = observations.datasets[d].channels[c];
        const std::string key = channel_key(observations, d, c);
        if (name != channel.name && name != channel.stream + "." + channel.name && name != key)
          continue;
        found = true;
        const double value = positive_quantity(place, quantity, channel);
        if (!tolerances.emplace(key, Tolerance{channel.unit, value}).second)
          throw InputError(
              fmt::format("{}: {} has a tolerance already; allowed: one a channel", place, key));
      }
    }
    if (!found) refuse_channel(place, name, observations);
  }
  return tolerances;
}

}  // namespace jaculus::diagnosis
