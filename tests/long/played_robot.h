#pragma once
// A robot in MuJoCo as its file has it: on a free base, with feet, a floor, and pins where the file
// can't say that loops close.
//
// The bodies are MuJoCo's own of the file (URDF). What robot.yaml attaches is put on them as bodies
// of MuJoCo with the same joints. What a file can't say comes from the planar model: feet, pins,
// rotors, friction of motors. Contact: feet are spheres of 2 mm on a plane; nothing else touches.

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "jaculus/model/robot.h"
#include "jaculus/transcription/problem.h"
#include "long/mujoco_file.h"

namespace jaculus::test {

/// The robot that a plan of `problem` is played on: as its files have it, with the problem's locked
/// joints. Its limits (friction, voltage, torque, current) say what the plan may use of that robot,
/// not what robot and floor are: where the floor has no more friction than a plan asks for, a foot
/// slips at the least thing that the plane leaves out.
model::PlanarModel played_model(const transcription::Problem& problem,
                                const model::PlanarModel& model);

/// Largest torque that a plan of `problem` may ask of the motor behind a joint of the robot's file,
/// at the joint, by the problem's limits where it has its own [N m or N]; infinite without a motor.
double planned_limit(const transcription::Problem& problem, const model::PlanarModel& model,
                     const std::string& joint);

/// The bodies in space from the base on, with what is attached, lying as robot.yaml's `axes` say.
model::SpatialTree played_tree(const model::Robot& robot,
                               const std::vector<model::Override>& overrides);

/// The file of a robot's bodies, to give to PlayedRobot: its own, or, where its base hangs on the
/// slides and the hinge that planar files have for a floating one, what that holds from the base
/// on, which is gone with the object.
class BodiesFile {
 public:
  explicit BodiesFile(const model::Robot& robot);
  ~BodiesFile();
  BodiesFile(const BodiesFile&) = delete;
  BodiesFile& operator=(const BodiesFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool own_ = false;
};

/// First state and last pose of the plan.
struct Ends {
  Eigen::Vector3d first_base, last_base;  ///< x, z [m], pitch [rad]
  std::map<std::string, double> first;    ///< joints of the plan [rad or m]
};

/// What a robot of the files has beside the plan's model, of which a playing can be freed.
enum class Part {
  none,
  friction,  ///< of joints: only what the plan's model has
  armature,  ///< the same
  contact    ///< feet grip, whatever the floor's friction
};

class PlayedRobot {
 public:
  static constexpr double kStep = 1e-4;  ///< of the integration [s]

  /// `file`: of the robot's bodies; `tree`: the same with what is attached, as played_tree() gives
  /// it; `ends`: the plan's.
  PlayedRobot(const model::PlanarModel& planar, const std::filesystem::path& file,
              const model::SpatialTree& tree, const Ends& ends);

  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] mjData& data() { return *data_; }

  /// From now on without that part.
  void without(Part part);

  /// MuJoCo's number of a joint. InputError where there is none.
  [[nodiscard]] int joint(const std::string& name) const;

  /// x, z [m] and pitch [rad] of the base.
  [[nodiscard]] Eigen::Vector3d base() const;
  /// y of the base [m] and the angle that its axis leans [rad].
  [[nodiscard]] std::array<double, 2> out_of_plane() const;

  [[nodiscard]] Eigen::Matrix3d rotation(int body) const;

  /// The bodies of MuJoCo that a planar body stands for, left first; the base's is the root.
  [[nodiscard]] std::vector<int> sides(int body) const;

 private:
  using Data = std::unique_ptr<mjData, void (*)(mjData*)>;

  [[nodiscard]] std::string as_mjcf();
  [[nodiscard]] std::string name_of(int body) const;
  [[nodiscard]] Eigen::Vector3d in_space(int body, int side, const Vec2& at,
                                         const Ends& ends) const;
  [[nodiscard]] Eigen::Vector3d in_frame(int side, const Eigen::Vector3d& point) const;
  void insert_after(const std::string& tag, const std::string& more);
  void load();
  void set_state(const Ends& ends);
  void add_attached(const model::SpatialTree& tree);
  void add_contact(const Ends& ends);
  [[nodiscard]] std::vector<std::array<Eigen::Vector3d, 2>> add_pins(const Ends& ends);
  void settle();
  void settle_motors();

  const model::PlanarModel& planar_;
  Eigen::Matrix3d axes_;  ///< of the file's root in the robot's frame
  MujocoModel model_;
  Data data_;
  std::string text_;
};

}  // namespace jaculus::test
