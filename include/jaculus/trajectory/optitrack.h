#pragma once
// Motion capture as OptiTrack's Motive exports it, CSV of format version 1.1 and later.
//
// Version 1.1 has a keyword a line: `righthanded`, `info,...`, `rigidbody,NAME,ID,...`, and
// `frame,INDEX,TIME,COUNT` with, for each body, ID, x, y, z, qx, qy, qz, qw, yaw, pitch, roll;
// metres.
// Later versions have one line of KEY,VALUE pairs (Format Version, Export Frame Rate, Rotation
// Type, Length Units, ...), rows that name each column (Type, Name, ID, perhaps Parent, Rotation or
// Position), a line `Frame,Time (Seconds),X,Y,Z,W,...`, then frames; an empty cell is a gap.
// Rotations are quaternions, or Euler angles in degrees of any order, taken as turns about the
// body's own axes in the order named: "XYZ" is Rx(a) Ry(b) Rz(c).
// Columns of markers and bones are passed over.

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "jaculus/core/names.h"
#include "jaculus/core/types.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

struct MocapBody {
  std::string name;
  Matrix position;  ///< 3 x frames, in the file's axes [m]; NaN in a gap
  Matrix rotation;  ///< 4 x frames, unit quaternion x, y, z, w of body to file axes; NaN in a gap
};

struct MocapTake {
  std::string version;    ///< "1.23"
  double rate_hz = kNaN;  ///< of the export; NaN where not stated [Hz]
  Vector time;            ///< [s], strictly rising
  std::vector<MocapBody> bodies;
  std::vector<std::string> notes;  ///< what was assumed or dropped, one sentence each
};

/// Reads an export in one pass. No rigid body, unknown unit or rotation, time that does not rise, a
/// frame of another length: InputError with file:line. A last frame that is cut short is dropped,
/// with a note.
MocapTake read_optitrack(const std::filesystem::path& file);
MocapTake read_optitrack(std::istream& stream, const std::string& name);

/// File axis that points up.
enum class MocapUp {
  y,  ///< Motive's own
  z
};

/// What points forward: an axis of the file, or where the body goes.
enum class MocapForward {
  automatic,  ///< the file's axis within 15 degrees of the body's displacement, or else that
  motion,     ///< along the body's displacement
  plus_x,
  minus_x,
  plus_y,
  minus_y,
  plus_z,
  minus_z
};

/// "y", "z".
const NameTable<MocapUp>& mocap_ups();
/// "auto", "motion", "+x", "-x", ...
const NameTable<MocapForward>& mocap_forwards();

/// How a take becomes x forward, y left, z up.
struct MocapAxes {
  MocapUp up = MocapUp::y;
  MocapForward forward = MocapForward::automatic;
  std::string body = {};  ///< which is the robot's base; empty: the first
  double rest = 0.1;  ///< the first seconds, at rest; zero of x, y and the angles is their mean [s]
};

/// The channels of a dataset's mocap stream: of the base x, y (from rest), z (absolute), pitch
/// (from rest, nose-down positive), roll, yaw; of every other body the same with its name before
/// them. Angles: R(t) R(rest)^T = Ry(pitch) Rz(yaw) Rx(roll), unwrapped. `notes` gets what was
/// assumed. InputError where the body is unknown or never seen at rest.
Stream mocap_stream(const MocapTake& take, const MocapAxes& axes, std::vector<std::string>& notes);

}  // namespace jaculus::trajectory
