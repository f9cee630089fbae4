// Bad overrides of a good robot's values: each message names the place, what was given, what is
// allowed.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "jaculus/model/robot.h"
#include "model/bad_robot.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

using testing::kUrdf;
using testing::kYaml;

TEST(BadRobot, Overrides) {
  struct Case {
    const char* text;     ///< the entries of `override`, a line each from line 2 on
    const char* message;  ///< as above
  };
  const std::vector<Case> cases = {
      {"  sail.drag.coeficient: 2\n",
       "p.yaml:2: override.sail.drag.coeficient: unknown model value 'sail.drag.coeficient', did "
       "you mean "
       "'sail.drag.coefficient'?..."},
      {"  motors.*.resistence: 2\n",
       "p.yaml:2: override.motors.*.resistence: unknown model value..."},
      {"  motors.a.resistance: 2 V\n",
       "p.yaml:2: override.motors.a.resistance: '2 V' is in V; allowed: a number in ohm..."},
      {"  motors.a.resistance: 0\n",
       "p.yaml:2: override.motors.a.resistance: 0 is out of range; allowed: at least 1e-12 ohm"},
      {"  bodies.b.mass: -1\n",
       "p.yaml:2: override.bodies.b.mass: -1 is out of range; allowed: at least 1e-12 kg"},
      {"  bodies.b.mass: 1\n  b.mass: 2\n",
       "p.yaml:3: override.b.mass: override 'b.mass' sets bodies.b.mass, which 'bodies.b.mass' "
       "(line 2) sets as well; "
       "allowed: once"},
      {"  motors.*.torque_limit: 1\n  '*.a.torque_limit': 2\n",
       "p.yaml:3: override.*.a.torque_limit: override '*.a.torque_limit' sets..."},
      {"  b.mass: =c.mass\n  c.mass: =d.mass\n  d.mass: =b.mass\n",
       "p.yaml:2: override.b.mass: override goes round in a circle: bodies.b.mass -> bodies.c.mass "
       "-> bodies.d.mass -> "
       "bodies.b.mass; ..."},
      {"  b.mass: =b.mass\n",
       "p.yaml:2: override.b.mass: override goes round in a circle: bodies.b.mass -> "
       "bodies.b.mass; ..."},
      {"  b.mass: =c.mas\n",
       "p.yaml:2: override.b.mass: unknown model value 'c.mas', did you mean 'c.mass'?..."},
      {"  b.mass: =friction\n",
       "p.yaml:2: override.b.mass: friction is 0.8 [-], bodies.b.mass is 2 [kg]; allowed: a value "
       "of the same..."},
      {"  sail.drag.kind: round\n", "p.yaml:2: override.sail.drag.kind: 'round' given..."},
      {"  b.com: 3\n", "p.yaml:2: override.b.com: '3' given; allowed: a list, [a, b, ...]"},
      {"  gravity: .inf\n", "p.yaml:2: override.gravity: '.inf' is not a number..."},
  };
  const testing::Folder folder;
  folder.write("robot.urdf", kUrdf);
  folder.write("robot.yaml", kYaml);
  for (const Case& c : cases) {
    const yaml::Node node = yaml::Node::parse("override:\n" + std::string(c.text), "p.yaml");
    std::vector<Override> overrides;
    for (const auto& [path, value] : node.at("override").entries())
      overrides.push_back({path, value});
    std::string expected = c.message;
    std::string given = "accepted";
    try {
      (void)read_robot(folder.path(), overrides);
    } catch (const InputError& e) {
      given = e.what();
    }
    if (expected.ends_with("...")) {
      expected.resize(expected.size() - 3);
      given = given.substr(0, expected.size());
    }
    EXPECT_EQ(given, expected) << c.text;
  }
}

}  // namespace
}  // namespace jaculus::model
