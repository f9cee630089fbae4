#include "jaculus/trajectory/optitrack.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "support/input_error.h"

namespace jaculus::trajectory {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::holds;
using test::input_error_of;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kFrames = 60;

/// A known leap in the world's axes: x forward, y left, z up.
struct Truth {
  static double time(int k) { return k / 120.0; }
  static double moving(int k) { return std::max(0.0, time(k) - 0.2); }
  static double x(int k) { return 0.4 * moving(k); }
  static double z(int k) { return 0.16 + 0.3 * moving(k); }
  static double pitch(int k) { return -8.0 * moving(k); }  // past -90 degrees
  static double yaw(int k) { return 0.1 * moving(k); }
  static double roll(int k) { return -0.2 * moving(k); }
  static Vector3d position(int k) { return {x(k) + 1.5, -0.7, z(k)}; }
  /// The body's axes on the robot are skewed, as they are after a rigid body is made from markers.
  static Quaterniond rotation(int k) {
    return Quaterniond(AngleAxisd(pitch(k), Vector3d::UnitY()) *
                       AngleAxisd(yaw(k), Vector3d::UnitZ()) *
                       AngleAxisd(roll(k), Vector3d::UnitX())) *
           Quaterniond(AngleAxisd(0.3, Vector3d(1.0, 2.0, 0.5).normalized()));
  }
};

struct Style {
  std::string up = "y", forward = "+z", units = "Meters", rotation = "Quaternion";
  double scale = 1.0;
  bool parent_row = false, two_bodies = false;
  int gap = -1;
};

Matrix3d file_from_world(const Style& style) {
  const auto axis = [](const std::string& name) {
    return Vector3d((name[0] == '-' ? -1.0 : 1.0) * Vector3d::Unit(name[1] - 'x'));
  };
  const Vector3d up = axis("+" + style.up), forward = axis(style.forward);
  Matrix3d R_FW;
  R_FW << forward, up.cross(forward), up;
  return R_FW;
}

std::string body_cells(const Style& style, int k) {
  if (k == style.gap) return std::string(style.rotation == "Quaternion" ? 8 : 7, ',');
  const Matrix3d R_FW = file_from_world(style);
  const Vector3d p = R_FW * Truth::position(k) / style.scale;
  const Matrix3d R = R_FW * Truth::rotation(k).toRotationMatrix();
  std::string out;
  if (style.rotation == "Quaternion") {
    const Quaterniond q(R);
    out = fmt::format(",{},{},{},{}", q.x(), q.y(), q.z(), q.w());
  } else {
    const auto index = [&](int i) { return (style.rotation[i] - 'X'); };
    const Vector3d turns = R.eulerAngles(index(0), index(1), index(2));
    Vector3d by_axis;
    for (int i = 0; i < 3; ++i) by_axis[index(i)] = turns[i] / kDegree;
    out = fmt::format(",{},{},{}", by_axis.x(), by_axis.y(), by_axis.z());
  }
  return out + fmt::format(",{},{},{},0.0001", p.x(), p.y(), p.z());
}

std::string motive_file(const Style& style) {
  const std::size_t turns = style.rotation == "Quaternion" ? 4 : 3;
  const int bodies = style.two_bodies ? 2 : 1;
  std::string kinds = ",Type", names = ",Name", ids = ",ID", parents = ",Parent", parts = ",",
              axes = "Frame,Time (Seconds)";
  for (int b = 0; b < bodies; ++b) {
    for (std::size_t i = 0; i < turns + 4; ++i) {
      kinds += ",Rigid Body";
      names += b == 0 ? ",Robot" : ",Tail";
      ids += fmt::format(",{}", b + 1);
      parents += ",";
      parts += i < turns ? ",Rotation" : i < turns + 3 ? ",Position" : ",Mean Marker Error";
      axes += i < turns       ? std::string(",") + "XYZW"[i]
              : i < turns + 3 ? std::string(",") + "XYZ"[i - turns]
                              : ",";
    }
  }
  for (int i = 0; i < 3; ++i) {
    kinds += ",Marker";
    names += ",Unlabeled 1";
    ids += ",9";
    parents += ",";
    parts += ",Position";
    axes += std::string(",") + "XYZ"[i];
  }
  std::string out = fmt::format(
      "Format Version,1.23,Take Name,Take 1,Take Notes,,Capture Frame Rate,120.000000,Export Frame "
      "Rate,120.000000,"
      "Total Exported Frames,{},Rotation Type,{},Length Units,{},Coordinate Space,Global\r\n\r\n",
      kFrames, style.rotation, style.units);
  out += kinds + "\r\n" + names + "\r\n" + ids + "\r\n" +
         (style.parent_row ? parents + "\r\n" : "") + parts + "\r\n" + axes + "\r\n";
  for (int k = 0; k < kFrames; ++k) {
    out += fmt::format("{},{:.6f}", k, Truth::time(k));
    for (int b = 0; b < bodies; ++b) out += body_cells(style, k);
    out += ",,,\r\n";
  }
  return out;
}

MocapTake take_of(const std::string& text) {
  std::istringstream stream(text);
  return read_optitrack(stream, "take.csv");
}

void expect_truth(const Stream& stream, const Style& style) {
  const double z0 = Truth::z(0);
  for (int k = 0; k < kFrames; ++k) {
    const auto value = [&](const char* channel) {
      return stream.values(stream.channel(channel), k);
    };
    if (k == style.gap) {
      EXPECT_TRUE(std::isnan(value("x")) && std::isnan(value("pitch")));
      continue;
    }
    EXPECT_NEAR(value("x"), Truth::x(k), 1e-9) << k;
    EXPECT_NEAR(value("y"), 0.0, 1e-9);
    EXPECT_NEAR(value("z"), z0 + 0.3 * Truth::moving(k), 1e-9);
    EXPECT_NEAR(value("pitch"), Truth::pitch(k), 1e-9) << k;
    EXPECT_NEAR(value("yaw"), Truth::yaw(k), 1e-9);
    EXPECT_NEAR(value("roll"), Truth::roll(k), 1e-9);
  }
}

TEST(OptiTrack, EveryConventionGivesTheSameMotion) {
  const std::vector<Style> styles = {
      {},
      {.up = "z", .forward = "+x"},
      {.up = "z", .forward = "-y", .units = "Millimeters", .scale = 1e-3, .parent_row = true},
      {.up = "y", .forward = "-x", .units = "Centimeters", .rotation = "XYZ", .scale = 1e-2},
      {.rotation = "YXZ", .gap = 30},
      {.rotation = "ZYX", .parent_row = true, .two_bodies = true},
  };
  for (const Style& style : styles) {
    SCOPED_TRACE(style.up + style.forward + style.units + style.rotation);
    const MocapTake take = take_of(motive_file(style));
    EXPECT_EQ(take.version, "1.23");
    EXPECT_EQ(take.rate_hz, 120.0);
    ASSERT_EQ(take.bodies.size(), style.two_bodies ? 2u : 1u);
    std::vector<std::string> notes;
    MocapAxes axes;
    axes.up = *mocap_ups().find(style.up);
    const Stream automatic = mocap_stream(take, axes, notes);
    expect_truth(automatic, style);
    EXPECT_TRUE(holds(notes.front() + (notes.size() > 1 ? notes[1] : ""),
                      "forward is taken as " + style.forward));
    axes.forward = *mocap_forwards().find(style.forward);
    axes.body = "Robot";
    expect_truth(mocap_stream(take, axes, notes), style);
    EXPECT_EQ(automatic.channel("Tail_pitch") >= 0, style.two_bodies);
  }
}

TEST(OptiTrack, AMotionBetweenTheAxesTurnsThem) {
  MocapTake take = take_of(motive_file({}));
  const Matrix3d turn = AngleAxisd(0.6, Vector3d::UnitY()).toRotationMatrix();
  for (int k = 0; k < kFrames; ++k) {
    take.bodies[0].position.col(k) = turn * Vector3d(take.bodies[0].position.col(k));
    take.bodies[0].rotation.col(k) =
        (Quaterniond(turn) * Quaterniond(Eigen::Vector4d(take.bodies[0].rotation.col(k)))).coeffs();
  }
  std::vector<std::string> notes;
  expect_truth(mocap_stream(take, {}, notes), {});
  EXPECT_TRUE(holds(notes.front(), "along the body's motion"));
}

TEST(OptiTrack, ReadsVersion11) {
  const Style style;
  std::string text =
      "comment,made up\nrighthanded\ninfo,version,1.1\ninfo,framecount,60\ninfo,rigidbodycount,1\n"
      "rigidbody,Robot,7,3\n";
  const Matrix3d R_FW = file_from_world(style);
  for (int k = 0; k < kFrames; ++k) {
    const Vector3d p = R_FW * Truth::position(k);
    const Quaterniond q(R_FW * Truth::rotation(k).toRotationMatrix());
    if (k == 12) {
      text += fmt::format("frame,{},{:.6f},0,0\n", k, Truth::time(k));
    } else {
      text += fmt::format("frame,{},{:.6f},1,7,{},{},{},{},{},{},{},0,0,0,0\n", k, Truth::time(k),
                          p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    }
  }
  std::vector<std::string> notes;
  expect_truth(mocap_stream(take_of(text), {}, notes), {.gap = 12});
}

TEST(OptiTrack, ACutOffTailIsDroppedAndSaid) {
  std::string text = motive_file({});
  text.resize(text.size() - 60);
  const MocapTake take = take_of(text);
  EXPECT_EQ(take.time.size(), kFrames - 1);
  EXPECT_TRUE(holds(take.notes.back(), "the last, is cut short"));
}

TEST(OptiTrack, BadFilesNameThePlace) {
  const std::string good = motive_file({});
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string text = good;
    return text.replace(text.find(what), what.size(), by);
  };
  struct Case {
    std::string text, message;
  };
  const std::vector<Case> cases = {
      {"", "take.csv: the file is empty"},
      {"time,x\n1,2\n", "take.csv:1: 'time' begins the line; allowed: 'Format Version'"},
      {with("Format Version,1.23", "Format Version,3"), "take.csv:1: Format Version '3' given"},
      {with("Length Units,Meters", "Length Units,Furlongs"),
       "take.csv:1: Length Units 'Furlongs' given; allowed: Meters"},
      {with("Rotation Type,Quaternion", "Rotation Type,XXZ"),
       "take.csv:1: Rotation Type 'XXZ' given"},
      {with("Space,Global", "Space,Local"), "Coordinate Space 'Local' given"},
      {good.substr(0, good.find("Frame,Time")), "no line 'Frame,Time (Seconds),...' follows"},
      {good.substr(0, good.find("\n0,0.000000") + 1), "there is a header but no frame"},
      {with("\n3,0.025000", "\n3,0.005"), "take.csv:11: time 0.005 s follows 0.016667 s"},
      {with("\n3,0.025000", "\n3,0.016667"), "take.csv:11: time 0.016667 s follows 0.016667 s"},
      {with("\n3,0.025000,", "\n3,0.025000,abc"), "take.csv:11: 'abc"},
      {with("\n3,0.025000,", "\n3\n3,0.025000,"), "take.csv:11: the frame has fewer cells"},
      {with("Rotation,Rotation", "Rotation,Something"), "body 'Robot' lacks columns"},
  };
  for (const Case& c : cases)
    EXPECT_TRUE(holds(input_error_of([&] { (void)take_of(c.text); }), c.message));
  const MocapTake take = take_of(good);
  std::vector<std::string> notes;
  const auto fault = [&](const MocapAxes& axes) {
    return input_error_of([&] { (void)mocap_stream(take, axes, notes); });
  };
  EXPECT_TRUE(holds(fault({.body = "Robo"}), "body: 'Robo' given, did you mean 'Robot'?"));
  EXPECT_TRUE(holds(fault({.forward = MocapForward::plus_y}), "forward: +y given while y is up"));
  EXPECT_TRUE(holds(fault({.up = MocapUp::z, .forward = MocapForward::minus_z}),
                    "forward: -z given while z is up"));
}

}  // namespace
}  // namespace jaculus::trajectory
