#include "diagnosis/forward/prediction_memory.h"

#include <boost/container_hash/hash.hpp>
#include <cassert>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace jaculus::diagnosis {
namespace {

/// Which simulation, and the parameters that are not at nominal.
struct Key {
  int dataset = 0, segment = 0;
  std::vector<std::pair<int, double>> moved;

  bool operator==(const Key&) const = default;
};

struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::size_t hash = 0;
    boost::hash_combine(hash, key.dataset);
    boost::hash_combine(hash, key.segment);
    boost::hash_combine(hash, key.moved);
    return hash;
  }
};

Key key_of(int dataset, int segment, const Vector& p, const Vector& nominal) {
  Key key{dataset, segment, {}};
  for (int i = 0; i < count_of(p); ++i)
    if (p[i] != nominal[i]) key.moved.emplace_back(i, p[i]);
  return key;
}

/// Shared by threads.
class Memory {
 public:
  explicit Memory(double megabytes) : left_(1e6 * megabytes) {}

  std::shared_ptr<const Prediction> find(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto found = known_.find(key);
    return found == known_.end() ? nullptr : found->second;
  }

  void keep(Key key, const Prediction& prediction) {
    const double bytes = sizeof(double) * static_cast<double>(prediction.values.size()) +
                         sizeof(key.moved.front()) * static_cast<double>(key.moved.size()) +
                         kOverhead;
    const std::scoped_lock lock(mutex_);
    if (bytes > left_) return;
    if (known_.emplace(std::move(key), std::make_shared<const Prediction>(prediction)).second)
      left_ -= bytes;
  }

 private:
  static constexpr double kOverhead = 1000.0;  ///< of an entry, about: names, impacts, nodes [B]

  std::mutex mutex_;
  double left_;  ///< [B]
  std::unordered_map<Key, std::shared_ptr<const Prediction>, KeyHash> known_;
};

}  // namespace

ForwardModel remembering(ForwardModel model, Vector nominal, double megabytes) {
  const auto memory = std::make_shared<Memory>(megabytes);
  return [model = std::move(model), nominal = std::move(nominal), memory](
             int dataset, int segment, const Vector& p) -> Prediction {
    Key key = key_of(dataset, segment, p, nominal);
    if (const auto known = memory->find(key)) return *known;
    Prediction prediction = model(dataset, segment, p);
    memory->keep(std::move(key), prediction);
    return prediction;
  };
}

ForwardModel beside(ForwardModel model, const Hypotheses& own, const Problem& before) {
  const std::vector<FreeParameter>& fewer = before.hypotheses.parameters;
  std::vector<int> common, added;
  for (int i = 0; i < count_of(own.parameters); ++i) {
    const std::size_t next = common.size();
    const FreeParameter& p = own.parameters[i];
    const bool same =
        next < fewer.size() && p.owner == fewer[next].owner && p.name == fewer[next].name;
    (same ? common : added).push_back(i);
  }
  assert(common.size() == fewer.size());

  return [model = std::move(model), nominal = own.nominal(), before = before.forward,
          common = std::move(common),
          added = std::move(added)](int dataset, int segment, const Vector& p) -> Prediction {
    for (const int i : added)
      if (p[i] != nominal[i]) return model(dataset, segment, p);
    return before(dataset, segment, p(common));
  };
}

}  // namespace jaculus::diagnosis
