#include "model/mjcf_floor.h"

#ifdef JACULUS_HAS_MUJOCO

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace jaculus::model {
namespace {

constexpr mjtNum kDefaultFriction = 1.0;

/// Of the geom, or of its body where it has none.
std::string quoted_name(const mjModel& m, int geom) {
  const char* name = mj_id2name(&m, mjOBJ_GEOM, geom);
  if (name == nullptr || *name == '\0') name = mj_id2name(&m, mjOBJ_BODY, m.geom_bodyid[geom]);
  return fmt::format("'{}'", name == nullptr ? "" : name);
}

/// The contact pair that the file states of two geoms; -1: none.
int pair_of(const mjModel& m, int a, int b) {
  for (int p = 0; p < m.npair; ++p) {
    const int first = m.pair_geom1[p], second = m.pair_geom2[p];
    if ((first == a && second == b) || (first == b && second == a)) return p;
  }
  return -1;
}

bool collide(const mjModel& m, int a, int b) {
  return (m.geom_contype[a] & m.geom_conaffinity[b]) != 0 ||
         (m.geom_contype[b] & m.geom_conaffinity[a]) != 0 || pair_of(m, a, b) >= 0;
}

/// Whether a plane is nearer to level than to upright: walls of an arena are planes too.
bool faces_up(const mjModel& m, int geom) {
  mjtNum turn[9];
  mju_quat2Mat(turn, m.geom_quat + 4 * geom);
  const mjtNum level = std::abs(turn[8]), side = std::hypot(turn[2], turn[5]);
  return level > side;
}

/// What stands still, is as wide as the world and faces up; -1: nothing.
int floor_of(const mjModel& m, int geom) {
  for (int g = 0; g < m.ngeom; ++g) {
    const bool wide = m.geom_type[g] == mjGEOM_PLANE || m.geom_type[g] == mjGEOM_HFIELD;
    if (wide && faces_up(m, g) && m.body_weldid[m.geom_bodyid[g]] == 0 && collide(m, geom, g))
      return g;
  }
  return -1;
}

Surface checked(double friction, int condim, const std::string& source) {
  if (condim == 1) return {"", kNaN, source + " without friction (condim 1)"};
  return {"", friction, source};
}

/// By the rules of mj_contactParam.
Surface mixed(const mjModel& m, int geom, int floor) {
  const mjtNum own = m.geom_friction[3 * geom], its = m.geom_friction[3 * floor];
  const std::string both = fmt::format("{} ({:.4g}) on {} ({:.4g})", quoted_name(m, geom), own,
                                       quoted_name(m, floor), its);
  const int first = m.geom_priority[geom], second = m.geom_priority[floor];
  if (first != second) {
    const int chosen = first > second ? geom : floor;
    return checked(m.geom_friction[3 * chosen], m.geom_condim[chosen],
                   both + ", of which one has priority");
  }
  if (own == kDefaultFriction && its == kDefaultFriction) return {};
  return checked(std::max(own, its), std::max(m.geom_condim[geom], m.geom_condim[floor]),
                 own == its ? both : both + ", of which MuJoCo takes the larger");
}

}  // namespace

Surface surface_on_floor(const mjModel& m, int geom) {
  const int floor = floor_of(m, geom);
  const mjtNum own = m.geom_friction[3 * geom];
  if (floor < 0 && own == kDefaultFriction) return {};
  if (floor < 0)
    return {"", own,
            fmt::format("{}; the file has no plane or height field that it meets",
                        quoted_name(m, geom))};

  const int pair = pair_of(m, geom, floor);
  if (pair >= 0)
    return checked(m.pair_friction[5 * pair], m.pair_dim[pair],
                   fmt::format("<pair> of {} and {}", quoted_name(m, geom), quoted_name(m, floor)));
  return mixed(m, geom, floor);
}

}  // namespace jaculus::model

#endif
