// Compares an imported robot with MuJoCo's own reading of the same file: total mass, centre of mass
// and pitch inertia about it, with all joints at zero and at a bent pose, held joints where
// robot.yaml holds them. scripts/check_robots runs it.
//
//   compare_mujoco FILE FOLDER     FILE: URDF or MJCF; FOLDER: of `jaculus robot import`
//
// Prints one line of JSON: the largest relative differences. Masses and inertias that the reader
// had to assume are given to MuJoCo too, and counted; MuJoCo's own kinematics and everything else
// are its own.

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "jaculus/model/robot.h"
#include "long/mujoco_file.h"
#include "long/planar_pose.h"

namespace {

namespace fs = std::filesystem;
using namespace jaculus;
using model::Mat3;
using model::Vec3;
using Model = test::MujocoModel;

/// Mass [kg], place of its centre [m] and inertia about it [kg m^2], in the plane.
struct Lump {
  double mass = 0.0;
  Vec2 com = Vec2::Zero();
  double inertia = 0.0;
};

void add(Lump& sum, const Lump& part) {
  const double mass = sum.mass + part.mass;
  if (!(mass > 0.0)) return;
  const Vec2 apart = part.com - sum.com;
  sum.inertia += part.inertia + sum.mass * part.mass / mass * apart.squaredNorm();
  sum.com += part.mass / mass * apart;
  sum.mass = mass;
}

/// Gives MuJoCo the bodies whose mass or inertia jaculus had to assume; how many.
int patch(mjModel& m, const model::SpatialTree& tree, const fs::path& file) {
  if (model::is_mjcf(file)) return 0;
  int patched = 0;
  for (const model::SpatialLink& link : tree.links) {
    const int b = mj_name2id(&m, mjOBJ_BODY, link.name.c_str());
    if (b < 0) continue;
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(link.inertia);
    const Vec3 moments = axes.eigenvalues();
    const bool physical =
        link.mass > 0.0 && moments[0] > 0.0 && moments[2] <= moments[0] + moments[1];
    bool sphere = std::abs(moments[0] - moments[2]) <= 1e-12 * moments[2];
    if (physical && !sphere) continue;
    // an unphysical one: as it is; one without inertia: as assumed; a true sphere: the same
    Mat3 R = axes.eigenvectors();
    if (R.determinant() < 0.0) R.col(0) = -R.col(0);
    const Eigen::Quaterniond q(R);
    const double old =
        m.body_inertia[3 * b] + m.body_inertia[3 * b + 1] + m.body_inertia[3 * b + 2];
    if (std::abs(old - moments.sum()) > 1e-9 * moments.sum() || !physical) ++patched;
    m.body_mass[b] = link.mass;
    const std::array<double, 4> quat{q.w(), q.x(), q.y(), q.z()};
    std::copy(quat.begin(), quat.end(), m.body_iquat + 4 * b);
    std::copy(moments.data(), moments.data() + 3, m.body_inertia + 3 * b);
  }
  return patched;
}

Vec3 direction(const std::string& axis) {
  Vec3 v = Vec3::Zero();
  v[axis.at(1) - 'x'] = axis.at(0) == '-' ? -1.0 : 1.0;
  return v;
}

/// robot.yaml's frame and joints, in space.
struct Files {
  Vec3 forward = Vec3::UnitX(), up = Vec3::UnitZ();
  std::string base;                                       ///< link; empty where the root
  std::map<std::string, double> held;                     ///< [rad or m]
  std::map<std::string, std::vector<std::string>> sides;  ///< of each pair
};

Files read_files(const fs::path& folder) {
  const yaml::Node node = yaml::Node::load(folder / "robot.yaml");
  Files files;
  if (const auto axes = node.find("axes")) {
    files.forward = direction(axes->at("forward").text());
    files.up = direction(axes->at("up").text());
  }
  if (const auto base = node.find("base_link")) files.base = base->text();
  if (const auto held = node.find("fixed_joints")) {
    for (const auto& [name, value] : held->entries()) files.held[name] = std::stod(value.dump());
  }
  if (const auto pairs = node.find("pairs")) {
    for (const auto& [name, value] : pairs->at("joints").entries())
      files.sides[name] = value.texts();
  }
  return files;
}

/// What the planar model adds up to, every joint where `angles` says.
Lump planar(const model::PlanarModel& model, const std::map<std::string, double>& angles) {
  const std::vector<Vec3> pose = test::place_bodies(model, Vec3::Zero(), angles);
  Lump sum;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    const Vec2 com = pose[b].head<2>() + Eigen::Rotation2Dd(-pose[b][2]) * body.com;
    add(sum, {body.mass, com, body.inertia});
  }
  return sum;
}

/// The same of the bodies of MuJoCo, in the file's axes.
Lump spatial(const mjModel& m, const mjData& d, const Files& files,
             const std::vector<int>& bodies) {
  const Vec3 left = files.up.cross(files.forward);
  Lump sum;
  for (const int b : bodies) {
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Mat3 R = Eigen::Map<const Rows>(d.ximat + 9 * b);
    const Vec3 moments(m.body_inertia[3 * b], m.body_inertia[3 * b + 1], m.body_inertia[3 * b + 2]);
    const Vec3 at(d.xipos[3 * b], d.xipos[3 * b + 1], d.xipos[3 * b + 2]);
    const Vec3 axis = R.transpose() * left;
    add(sum, {m.body_mass[b], Vec2(at.dot(files.forward), at.dot(files.up)),
              axis.cwiseAbs2().dot(moments)});
  }
  return sum;
}

double relative(double a, double b) { return std::abs(a - b) / std::max(std::abs(b), 1e-12); }

class Comparison {
 public:
  Comparison(const fs::path& file, const fs::path& folder)
      : files_(read_files(folder)),
        robot_(model::read_robot(folder)),
        tree_(model::read_urdf(folder / "robot.urdf")),
        model_(test::load_mujoco(file)) {
    patched_ = patch(*model_, tree_, file);
    data_ = mj_makeData(model_.get());
  }
  ~Comparison() { mj_deleteData(data_); }
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  void run() {
    const std::vector<int> bodies = own_bodies();
    std::array<Lump, 2> ours, theirs;
    for (std::size_t bent = 0; bent < 2; ++bent) {
      const std::map<std::string, double> angles = pose(bent == 1);
      ours[bent] = planar(robot_.planar, angles);
      set(angles);
      theirs[bent] = spatial(*model_, *data_, files_, bodies);
    }

    // the way of the centre of mass from pose to pose, against the radius of gyration: origins
    // differ
    const double size = std::sqrt(theirs[0].inertia / theirs[0].mass);
    const Vec2 way = ours[1].com - ours[0].com - (theirs[1].com - theirs[0].com);
    fmt::print(
        "{{\"mass\": {:.3e}, \"inertia\": {:.3e}, \"com_bent\": {:.3e}, \"inertia_bent\": {:.3e}, "
        "\"assumed_links\": {}, \"mass_kg\": {:.6g}, \"lean_deg\": {:.3g}}}\n",
        relative(ours[0].mass, theirs[0].mass), relative(ours[0].inertia, theirs[0].inertia),
        way.norm() / size, relative(ours[1].inertia, theirs[1].inertia), patched_,
        robot_.planar.total_mass(), lean());
  }

 private:
  /// MuJoCo's bodies of the links that the planar robot is made of.
  [[nodiscard]] std::vector<int> own_bodies() const {
    const model::SpatialTree part =
        files_.base.empty() ? tree_ : model::subtree(tree_, tree_.link_index(files_.base));
    std::vector<int> bodies;
    for (const model::SpatialLink& link : part.links) {
      const std::string name = link.name == "world" ? "jaculus_world" : link.name;
      int b = mj_name2id(model_.get(), mjOBJ_BODY, name.c_str());
      // read_mjcf calls what has no name by its number
      if (b < 0 && name.starts_with("body_")) b = std::stoi(name.substr(5));
      if (b > 0) bodies.push_back(b);
    }
    return bodies;
  }

  /// Joints of the planar robot: zero, or somewhere that differs from joint to joint; loops are
  /// left open, ranges don't count.
  [[nodiscard]] std::map<std::string, double> pose(bool bent) const {
    std::map<std::string, double> angles;
    int i = 0;
    for (const model::PlanarBody& body : robot_.planar.bodies) {
      const double wanted = bent ? 0.3 * (i % 3 - 1) + 0.2 : 0.0;
      angles[body.joint] = wanted;
      ++i;
    }
    return angles;
  }

  [[nodiscard]] double across(const std::string& joint) const {
    const model::SpatialJoint& j = tree_.joints[tree_.joint_index(joint)];
    return (tree_.links[j.child].R_BL * j.axis).dot(files_.up.cross(files_.forward));
  }

  /// How far axes of joints that move lean out of the plane at zero, at most [deg].
  [[nodiscard]] double lean() const {
    double most = 0.0;
    for (std::size_t b = 1; b < robot_.planar.bodies.size(); ++b) {
      if (robot_.planar.bodies[b].kind != model::JointKind::revolute) continue;
      for (const std::string& joint : sides(robot_.planar.bodies[b].joint))
        most = std::max(most, std::acos(std::min(1.0, std::abs(across(joint)))));
    }
    return most * 180.0 / M_PI;
  }

  [[nodiscard]] std::vector<std::string> sides(const std::string& joint) const {
    const auto found = files_.sides.find(joint);
    return found == files_.sides.end() ? std::vector<std::string>{joint} : found->second;
  }

  void set_joint(const std::string& name, double value) {
    const int j = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
    if (j < 0) throw InputError("MuJoCo has no joint '" + name + "'");
    const int at = model_->jnt_qposadr[j];
    data_->qpos[at] = model_->qpos0[at] + value;
  }

  void set(const std::map<std::string, double>& angles) {
    mj_resetData(model_.get(), data_);
    for (const auto& [joint, value] : files_.held) set_joint(joint, value);
    for (std::size_t b = 1; b < robot_.planar.bodies.size(); ++b) {
      const std::string& joint = robot_.planar.bodies[b].joint;
      const std::vector<std::string> both = sides(joint);
      for (const std::string& side : both) {
        const bool opposite = both.size() > 1 && across(side) * across(both[0]) < 0.0;
        set_joint(side, (opposite ? -1.0 : 1.0) * angles.at(joint));
      }
    }
    mj_kinematics(model_.get(), data_);
  }

  Files files_;
  model::Robot robot_;
  model::SpatialTree tree_;
  Model model_;
  mjData* data_ = nullptr;
  int patched_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: compare_mujoco FILE FOLDER\n");
    return 2;
  }
  try {
    Comparison(argv[1], argv[2]).run();
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
