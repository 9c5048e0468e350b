#include "core/dynamics/thin_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {
namespace {

template <class... Numbers>
std::string number_shown(const char* format, Numbers... numbers) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);
  return text.data();
}

/// A geom as seen along gravity.
struct Seen {
  int geom;
  double low, high;  // [m] along up
  bool falls;        // gravity moves it
  bool endless;      // a plane: nothing falls through
};

/// [m] Half of a geom's extent along a direction of the world.
double half_extent(const mjModel& model, const mjData& data, int geom, const Vec3& along) {
  const mjtNum* const turn = entry<9>(data.geom_xmat, geom);
  const Vec3 own(turn[0] * along.x() + turn[3] * along.y() + turn[6] * along.z(),
                 turn[1] * along.x() + turn[4] * along.y() + turn[7] * along.z(),
                 turn[2] * along.x() + turn[5] * along.y() + turn[8] * along.z());
  const Vec3 size = vector(entry<3>(model.geom_size, geom));
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return size.x();
    case mjGEOM_CAPSULE:
      return size.x() + size.y() * std::abs(own.z());
    case mjGEOM_CYLINDER:
      return size.x() * std::hypot(own.x(), own.y()) + size.y() * std::abs(own.z());
    case mjGEOM_ELLIPSOID:
      return own.cwiseProduct(size).norm();
    case mjGEOM_BOX:
      return own.cwiseAbs().dot(size);
    case mjGEOM_MESH: {
      const int mesh = model.geom_dataid[geom];
      const float* v = model.mesh_vert + std::ptrdiff_t{3} * model.mesh_vertadr[mesh];
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (int i = 0; i < model.mesh_vertnum[mesh]; ++i, v += 3) {
        const double at = own.dot(Vec3(v[0], v[1], v[2]));
        low = std::min(low, at);
        high = std::max(high, at);
      }
      return 0.5 * (high - low);
    }
    default:
      return model.geom_rbound[geom];
  }
}

/// Whether gravity moves a body: it, or one that carries it, is free or slides along `up`.
bool falls(const mjModel& model, const mjData& data, int body, const Vec3& up) {
  constexpr double kAlong = 0.1;
  for (; body != 0; body = model.body_parentid[body])
    for (int j = 0; j < model.body_jntnum[body]; ++j) {
      const int joint = model.body_jntadr[body] + j;
      if (model.jnt_type[joint] == mjJNT_FREE) return true;
      if (model.jnt_type[joint] == mjJNT_SLIDE &&
          std::abs(vector(entry<3>(data.xaxis, joint)).dot(up)) > kAlong)
        return true;
    }
  return false;
}

bool meet(const mjModel& model, int a, int b) {
  if (model.geom_bodyid[a] == model.geom_bodyid[b]) return false;
  return (model.geom_contype[a] & model.geom_conaffinity[b]) != 0 ||
         (model.geom_contype[b] & model.geom_conaffinity[a]) != 0;
}

/// Whether their shadows on the ground may have a point in common.
bool overlap(const mjModel& model, const mjData& data, int a, int b, const Vec3& up) {
  const Vec3 apart = vector(entry<3>(data.geom_xpos, a)) - vector(entry<3>(data.geom_xpos, b));
  return (apart - up.dot(apart) * up).norm() <= model.geom_rbound[a] + model.geom_rbound[b];
}

/// [s] The time constant of their contact.
double contact_time(const mjModel& model, int a, int b) {
  const auto of = [&](int geom) { return model.geom_solref[std::ptrdiff_t{mjNREF} * geom]; };
  const double shortest = 2.0 * model.opt.timestep;  // MuJoCo takes no shorter one
  return std::max({of(a), of(b), shortest});
}

/// [s] The longest of them.
double longest_contact_time(const mjModel& model) {
  double longest = 2.0 * model.opt.timestep;
  for (int g = 0; g < model.ngeom; ++g) longest = std::max(longest, contact_time(model, g, g));
  return longest;
}

std::string warning_of(const Object& upper, const Object& lower, const Seen& a, const Seen& b,
                       double drop, double speed, double held, double thickness, double tick,
                       double gravity) {
  const double share = held / speed;
  const auto thick = [](const Seen& seen) { return 1e3 * (seen.high - seen.low); };
  std::string text =
      "object '" + upper.name + "' (" + number_shown("%.3g mm", thick(a)) + " thick) falls " +
      number_shown("%.3g m", drop) + " onto '" + lower.name + "' (" +
      number_shown("%.3g mm", thick(b)) + ") and comes with " + number_shown("%.3g m/s", speed) +
      "; with a tick of " + number_shown("%.3g ms", 1e3 * tick) + " they hold each other up to " +
      number_shown("%.3g m/s", held) + ", so it may fall through; make them at least " +
      number_shown("%.3g mm", 1e3 * thickness / share) + " thick together";
  if (share * tick >= kLeastTick)
    text += ", or give a tick of at most " + number_shown("%.2g s", share * tick);
  return text + ", or let it begin at most " +
         number_shown("%.3g mm", 1e3 * held * held / (2.0 * gravity)) + " above";
}

}  // namespace

double held_speed(double thickness, double contact, double tick) {
  // A contact is a spring and a critical damper, so a body comes in by speed * contact / e. A tick
  // that passes before it begins adds up to kTicks of one (measured, ThinContacts.*).
  constexpr double kTicks = 0.65, kE = 2.718281828459045;
  return 0.5 * thickness / (contact / kE + kTicks * tick);
}

std::vector<std::string> thin_contacts(const mjModel& model, const mjData& data,
                                       const std::vector<Object>& objects,
                                       const std::vector<int>& object_of) {
  const Vec3 pull = vector(model.opt.gravity);
  const double gravity = pull.norm(), tick = model.opt.timestep;
  if (!(gravity > 0.0)) return {};
  const Vec3 up = -pull / gravity;

  std::vector<Seen> seen;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (int g = 0; g < model.ngeom; ++g) {
    if (object_of[static_cast<std::size_t>(g)] < 0 || model.geom_type[g] == mjGEOM_HFIELD) continue;
    const double middle = up.dot(vector(entry<3>(data.geom_xpos, g)));
    const bool endless = model.geom_type[g] == mjGEOM_PLANE;
    const double half = endless ? 0.0 : half_extent(model, data, g, up);
    const int body = model.geom_bodyid[g];
    seen.push_back({g, middle - half, middle + half,
                    model.body_weldid[body] != 0 && falls(model, data, body, up), endless});
    lowest = std::min(lowest, middle - half);
    highest = std::max(highest, middle + half);
  }
  // Nothing in the scene falls faster, so thicker bodies need no look.
  const double fastest = std::sqrt(2.0 * gravity * std::max(0.0, highest - lowest));
  const double slowest_hold = held_speed(1.0, longest_contact_time(model), tick);
  const auto is_thin = [&](const Seen& s) {
    return !s.endless && slowest_hold * (s.high - s.low) < fastest;
  };

  // How far each falls: to the highest of what does not move and lies below it.
  constexpr std::size_t kMostPairs = 20'000'000, kMostSaid = 16;
  std::size_t pairs = 0, more = 0;
  const auto drop_of = [&](const Seen& a) {
    double least = std::numeric_limits<double>::infinity();
    for (const Seen& b : seen) {
      ++pairs;
      if (b.falls || b.high > a.low || !meet(model, a.geom, b.geom)) continue;
      if (!b.endless && !overlap(model, data, a.geom, b.geom, up)) continue;
      least = std::min(least, a.low - b.high);
    }
    return std::isfinite(least) ? least : 0.0;
  };

  std::vector<std::string> warnings;
  for (const Seen& a : seen) {
    if (!a.falls || !is_thin(a)) continue;
    for (const Seen& b : seen) {
      if (++pairs > kMostPairs) break;
      if (!is_thin(b) || b.high > a.low || !meet(model, a.geom, b.geom) ||
          !overlap(model, data, a.geom, b.geom, up))
        continue;
      // A body that falls below it lies still when it arrives.
      const double drop = a.low - b.high + (b.falls ? drop_of(b) : 0.0);
      const double speed = std::sqrt(2.0 * gravity * drop);
      const double margin = std::max(model.geom_margin[a.geom], model.geom_margin[b.geom]);
      const double thickness = a.high - a.low + b.high - b.low;
      const double held =
          held_speed(thickness + 2.0 * margin, contact_time(model, a.geom, b.geom), tick);
      if (speed <= held) continue;
      if (warnings.size() == kMostSaid) {
        ++more;
        continue;
      }
      const auto object = [&](const Seen& s) -> const Object& {
        return objects[static_cast<std::size_t>(object_of[static_cast<std::size_t>(s.geom)])];
      };
      warnings.push_back(
          warning_of(object(a), object(b), a, b, drop, speed, held, thickness, tick, gravity));
    }
  }
  if (more > 0)
    warnings.push_back(std::to_string(more) +
                       " more pairs of bodies are too thin for the speed at which they meet");
  return warnings;
}

}  // namespace feltwire::mujoco
