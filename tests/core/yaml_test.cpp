#include "jaculus/core/yaml.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <vector>

namespace jaculus::yaml {
namespace {

namespace fs = std::filesystem;

Node parse(const std::string& text) { return Node::parse(text, "t.yaml"); }

TEST(Yaml, AFileOfAnotherKindIsRefusedByWhatItIs) {
  const Node problem = parse("format: jaculus-problem/1\nname: leap\n");
  EXPECT_NO_THROW(refuse_other_kind(problem, "jaculus-problem/1"));
  EXPECT_NO_THROW(refuse_other_kind(parse("format: other/3"), "jaculus-problem/1"));
  EXPECT_NO_THROW(refuse_other_kind(parse("[1, 2]"), "jaculus-problem/1"));
  try {
    refuse_other_kind(problem, "jaculus-experiment/1");
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("t.yaml:1"), std::string::npos) << what;
    EXPECT_NE(what.find("a problem given"), std::string::npos) << what;
    EXPECT_NE(what.find("jaculus solve"), std::string::npos) << what;
    EXPECT_NE(what.find("allowed here: an experiment"), std::string::npos) << what;
  }
}

TEST(Yaml, ReadsValues) {
  const Node n = parse(
      "a: 1.5\nb: 16 V\nc: \"15 deg\"\nd: [1, 2 mm]\ne: {f: true, g: word}\nh: [-.inf, 3]\ni: "
      "7\nj: [x, 'y']\nk: '3'\n"
      "l: +2e-3\nm: [0 V, \"1 kV\"]\n");
  EXPECT_EQ(n.at("a").number(dimension::voltage), 1.5);
  EXPECT_EQ(n.at("b").number(dimension::voltage), 16.0);
  EXPECT_NEAR(n.at("c").number(dimension::angle), 15.0 * M_PI / 180.0, 1e-15);
  EXPECT_EQ(n.at("d").vec2(dimension::length), Vec2(1.0, 0.002));
  EXPECT_TRUE(n.at("e").at("f").boolean());
  EXPECT_EQ(n.at("e").at("g").choice({"word", "other"}), "word");
  EXPECT_EQ(n.at("e").at("g").path(), "e.g");
  EXPECT_EQ(n.at("d").items()[1].path(), "d[1]");
  EXPECT_EQ(n.at("d").line(), 4);
  EXPECT_EQ(n.at("h").bounds(dimension::none).lower, -kInfinity);
  EXPECT_EQ(n.at("h").bounds(dimension::none).upper, 3.0);
  EXPECT_TRUE(n.at("i").bounds(dimension::none).fixed());
  EXPECT_EQ(n.at("i").integer(0, 9), 7);
  EXPECT_EQ(n.at("j").texts(), (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(n.at("k").text(), "3");
  EXPECT_EQ(n.at("l").number(dimension::none), 2e-3);
  EXPECT_EQ(n.at("m").numbers(dimension::voltage), (std::vector<double>{0.0, 1000.0}));
  EXPECT_TRUE(n.has("a"));
  EXPECT_FALSE(n.has("z"));
  EXPECT_FALSE(n.find("z").has_value());
  EXPECT_EQ(n.entries().size(), 11u);
  EXPECT_EQ(n.entries().front().first, "a");
}

TEST(Yaml, AliasesAreReadWhereTheyAreUsed) {
  const Node n = parse("a: &v {x: 1}\nb: *v\n");
  EXPECT_EQ(n.at("b").at("x").number(dimension::none), 1.0);
  EXPECT_EQ(n.at("b").at("x").path(), "b.x");
}

TEST(Yaml, DumpReadsBack) {
  const Node n = parse("a: [1, \"2 V\"]\nb: {c: word, d: '7'}\n");
  const Node again = parse(n.dump());
  EXPECT_EQ(again.at("a").items()[1].number(dimension::voltage), 2.0);
  EXPECT_EQ(again.at("b").at("d").text(), "7");
}

TEST(Yaml, ValuesBuiltInCodeHaveNoPlace) {
  const Node n;
  EXPECT_TRUE(n.is_map());
  EXPECT_EQ(n.line(), 0);
  EXPECT_STREQ(n.error("wrong").what(), "wrong");
}

struct Bad {
  const char* text;
  std::function<void(const Node&)> read;
  const char* message;  ///< the whole message, or its beginning where it ends in "..."
};

void expect_error(const std::string& text, const std::function<void(const Node&)>& read,
                  std::string message) {
  const bool prefix = message.ends_with("...");
  if (prefix) message.resize(message.size() - 3);
  try {
    read(parse(text));
    ADD_FAILURE() << "accepted: " << text;
  } catch (const InputError& e) {
    const std::string what = e.what();
    EXPECT_EQ(prefix ? what.substr(0, message.size()) : what, message) << text;
  }
}

const auto kNothing = [](const Node&) {};

TEST(Yaml, RefusesWithPlaceKeyGivenAndAllowed) {
  const auto number = [](const Dimension& d, Bounds b = {}) {
    return [=](const Node& n) { (void)n.at("a").number(d, b); };
  };
  const auto bounds = [](const Node& n) { (void)n.at("a").bounds(dimension::angle); };
  const std::vector<Bad> cases = {
      {"a: 1\nfrictoin: 2\n",
       [](const Node& n) {
         n.only({"a", "friction"});
       },
       "t.yaml:2: unknown key 'frictoin', did you mean 'friction'?; allowed: a, friction"},
      {"a:\n  qqq: 2\n", [](const Node& n) { n.at("a").only({"mass"}); },
       "t.yaml:2: a: unknown key 'qqq'; allowed: mass"},
      {"a: 5\n", [](const Node& n) { n.at("a").only({"mass"}); },
       "t.yaml:1: a: '5' given; allowed: a map with the keys mass"},
      {"a: 1\n", [](const Node& n) { (void)n.at("b"); },
       "t.yaml:1: key 'b' is missing; it must be given"},
      {"a: [1]\n", [](const Node& n) { (void)n.at("a").find("b"); },
       "t.yaml:1: a: a list given; allowed: a map"},
      {"a: 1\nb: 2\na: 3\n", kNothing, "t.yaml:3: key 'a' given twice in one map; allowed: once"},
      {"x: {k: 1, k: 2}\n", kNothing, "t.yaml:1: key 'k' given twice in one map; allowed: once"},
      {"a: word\n", number(dimension::mass),
       "t.yaml:1: a: 'word' is not a number; allowed: a number in kg, or a string with such a "
       "unit"},
      {"a: 3 V\n", number(dimension::mass),
       "t.yaml:1: a: '3 V' is in V; allowed: a number in kg..."},
      {"a: '3'\n", number(dimension::mass),
       "t.yaml:1: a: '3' has no unit; allowed: a number in kg..."},
      {"a: 3 deg\n", number(dimension::none),
       "t.yaml:1: a: '3 deg' is in rad; allowed: a plain number without a unit"},
      {"a: .nan\n", number(dimension::none), "t.yaml:1: a: '.nan' is not a number; ..."},
      {"a: nan\n", number(dimension::none), "t.yaml:1: a: 'nan' is not a finite number; ..."},
      {"a: .inf\n", number(dimension::none), "t.yaml:1: a: '.inf' is not a number; ..."},
      {"a: -inf\n", number(dimension::none), "t.yaml:1: a: '-inf' is not a finite number; ..."},
      {"a: 1e999\n", number(dimension::none),
       "t.yaml:1: a: '1e999' is too large or too small for a number; ..."},
      {"a:\n", number(dimension::none), "t.yaml:1: a: nothing given; allowed: a plain number"},
      {"a: [1]\n", number(dimension::time), "t.yaml:1: a: a list given; allowed: a number in s"},
      {"a: true\n", number(dimension::none), "t.yaml:1: a: 'true' is not a number; ..."},
      {"a: -1\n", number(dimension::mass, {0.0, kInfinity}),
       "t.yaml:1: a: -1 is out of range; allowed: at least 0 kg"},
      {"a: 1.5\n", number(dimension::none, {0.0, 1.0}),
       "t.yaml:1: a: 1.5 is out of range; allowed: 0 to 1"},
      {"a: 2 km\n", number(dimension::length, {-kInfinity, 5.0}),
       "t.yaml:1: a: 2 km is out of range; allowed: at most 5 m"},
      {"a: 1.5\n", [](const Node& n) { (void)n.at("a").integer(1, 9); },
       "t.yaml:1: a: '1.5' given; allowed: a whole number from 1 to 9"},
      {"a: 12\n", [](const Node& n) { (void)n.at("a").integer(1, 9); },
       "t.yaml:1: a: 12 is out of range; allowed: a whole number from 1 to 9"},
      {"a: 99999999999\n", [](const Node& n) { (void)n.at("a").integer(1, 9); },
       "t.yaml:1: a: 99999999999 is out of range; ..."},
      {"a: yes\n", [](const Node& n) { (void)n.at("a").boolean(); },
       "t.yaml:1: a: 'yes' given; allowed: true or false"},
      {"a: ''\n", [](const Node& n) { (void)n.at("a").text(); },
       "t.yaml:1: a: '' given; allowed: a text that is not empty"},
      {"a: 5\n", [](const Node& n) { (void)n.at("a").text(); },
       "t.yaml:1: a: '5' given; allowed: a text (in quotes..."},
      {"a: hled\n",
       [](const Node& n) {
         (void)n.at("a").choice({"held", "linear"});
       },
       "t.yaml:1: a: 'hled' given, did you mean 'held'?; allowed: held, linear"},
      {"a: {}\n", [](const Node& n) { (void)n.at("a").choice({"held"}); },
       "t.yaml:1: a: a map given; allowed: held"},
      {"a: [2, 1]\n", bounds,
       "t.yaml:1: a: lower bound 2 is above upper bound 1; allowed: lower <= upper, in rad"},
      {"a: [1]\n", bounds, "t.yaml:1: a: 1 values given; allowed: [lower, upper] in rad..."},
      {"a: [.inf, 1]\n", bounds, "t.yaml:1: a[0]: '.inf' is not a number; ..."},
      {"a: [0, -.inf]\n", bounds, "t.yaml:1: a[1]: '-.inf' is not a number; ..."},
      {"a: {x: 1}\n", bounds, "t.yaml:1: a: a map given; allowed: [lower, upper] in rad..."},
      {"a: [1, 2, 3]\n", [](const Node& n) { (void)n.at("a").vec2(dimension::length); },
       "t.yaml:1: a: 3 values given; allowed: two, [x, z] in m"},
      {"a:\n- 1\n- x\n", [](const Node& n) { (void)n.at("a").numbers(dimension::length); },
       "t.yaml:3: a[1]: 'x' is not..."},
      {"a: x\n", [](const Node& n) { (void)n.at("a").items(); },
       "t.yaml:1: a: 'x' given; allowed: a list, [a, b, ...]"},
      {"a: x\n", [](const Node& n) { (void)n.at("a").entries(); },
       "t.yaml:1: a: 'x' given; allowed: a map"},
      {"a: &x [1, *x]\n", kNothing, "t.yaml:1: alias to a node that contains it (cyclic)..."},
      {"a: &x {b: {c: *x}}\n", kNothing, "t.yaml:1: alias to a node that contains it (cyclic)..."},
      {"a: *nowhere\n", kNothing, "t.yaml:1: not valid YAML: ..."},
      {"a: 1\n---\nb: 2\n", kNothing,
       "t.yaml:3: a second document ('---'); allowed: one document a file"},
      {"a: !!int 5\n", kNothing, "t.yaml:1: tag 'tag:yaml.org,2002:int' is not supported; ..."},
      {"b: &m {x: 1}\na: {<<: *m}\n", kNothing,
       "t.yaml:2: key '<<': merge keys are not supported; ..."},
      {"? [1, 2]\n: 3\n", kNothing, "t.yaml:1: a key that is not plain text; ..."},
      {"", kNothing, "t.yaml:1: the file holds no value; allowed: a YAML document"},
      {"# only a comment\n", kNothing, "t.yaml:1: the file holds no value; ..."},
      {"a: [1, 2\nb: 3\n", kNothing, "t.yaml:2: not valid YAML: ..."},
      {"a: 1\n\tb: 2\n", kNothing, "t.yaml:2: not valid YAML: ..."},
      {"a: \"open\nb: 2\n", kNothing, "t.yaml:3: not valid YAML: a quote is not closed; ..."},
      {"a: 1\nb: \x01\n", kNothing, "t.yaml:2: byte 0x01 found; allowed: YAML in UTF-8 text"},
      {"a: 1\nb: \xff\xfe\n", kNothing, "t.yaml:2: byte 0xff found; allowed: YAML in UTF-8 text"},
  };
  for (const Bad& c : cases) expect_error(c.text, c.read, c.message);
}

class YamlFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(::testing::TempDir()) / ("jaculus_yaml_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& text) const {
    const fs::path file = folder_ / "f.yaml";
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

  static std::string message(const fs::path& file) {
    try {
      Node::load(file).only({"a"});
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(YamlFile, Loads) {
  EXPECT_EQ(Node::load(write("a: 2 ms\n")).at("a").number(dimension::time), 0.002);
}

TEST_F(YamlFile, RefusesWhatIsNoFile) {
  EXPECT_NE(message(folder_ / "absent.yaml").find("absent.yaml: file not found"),
            std::string::npos);
  EXPECT_NE(message(folder_).find("is a folder"), std::string::npos);
  EXPECT_NE(message("/dev/null").find("is no regular file"), std::string::npos);
  EXPECT_NE(message(write("")).find(":1: the file holds no value"), std::string::npos);
}

TEST_F(YamlFile, SurvivesGarbage) {
  std::mt19937 random(7);
  std::string binary(10'000'000, '\0');
  for (char& c : binary) c = static_cast<char>(random() & 0xFF);
  EXPECT_NE(message(write(binary)).find("UTF-8"), std::string::npos);
  EXPECT_NE(message(write(std::string(10'000'001, 'a'))).find("allowed: at most 10000000"),
            std::string::npos);
  std::string printable(1'000'000, ' ');
  for (char& c : printable) c = static_cast<char>(32 + random() % 95);
  EXPECT_NE(message(write(printable)), "");
}

TEST_F(YamlFile, SurvivesDeepAndWideNesting) {
  for (const char* unit : {"[", "{a: ", "- ", "[{a: ", "? "}) {
    std::string text;
    while (text.size() < 1'000'000) text += unit;
    EXPECT_NE(message(write(text)), "") << unit;
  }
  // "Billion laughs": each level names the one before it ten times.
  std::string text = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n";
  for (int i = 1; i < 12; ++i) {
    text += fmt::format("a{0}: &a{0} [*a{1}", i, i - 1);
    for (int j = 1; j < 10; ++j) text += fmt::format(", *a{}", i - 1);
    text += "]\n";
  }
  EXPECT_NE(message(write(text)).find("more than a million values"), std::string::npos);
}

TEST(NearestName, FindsTyposOnly) {
  const std::vector<std::string> names = {"friction", "gravity", "motors", "feet"};
  EXPECT_EQ(nearest_name("fricton", names), "friction");
  EXPECT_EQ(nearest_name("Gravity", names), "gravity");
  EXPECT_EQ(nearest_name("motor", names), "motors");
  EXPECT_EQ(nearest_name("foot", names), "feet");
  EXPECT_EQ(nearest_name("qqqqqqq", names), std::nullopt);
  EXPECT_EQ(nearest_name("", names), std::nullopt);
}

}  // namespace
}  // namespace jaculus::yaml
