// YAML, and the descriptions read from it.

#include "jaculus/core/yaml.h"

#include "fuzz/target.h"
#include "jaculus/trajectory/column_map.h"
#include "jaculus/trajectory/openlog.h"
#include "trajectory/dataset_yaml.h"

using namespace jaculus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  fuzz::refuse_politely([&] {
    const yaml::Node node = yaml::Node::parse(text, "fuzz.yaml");
    switch (data[0] % 4) {
      case 0:
        (void)node.dump();
        (void)trajectory::read_outline(node);
        break;
      case 1:
        (void)trajectory::read_openlog_format(node);
        break;
      case 2:
        (void)trajectory::read_column_map(node);
        break;
      default:
        (void)node.number(dimension::torque, {-1.0, 1e3});
    }
  });
  return 0;
}
