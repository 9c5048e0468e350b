#include "core/dynamics/thin_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/base/written_number.hpp"
#include "core/dynamics/geom_extent.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {
namespace {

/// The extent of a geom along gravity.
struct GeomExtent {
  int geom;
  double low, high;  // [m] lowest and highest point along `up`
  double thickness;  // [m] least extent in any direction
  bool falls;        // true if gravity moves the geom
  bool endless;      // true for a plane, because no body falls through it
  bool thin;         // true if an object may be too fast for this thickness
};

/// Returns the depth [m] of the surface of geom `surface_of` below the centre of geom `middle_of`,
/// or a negative value if the surface is not below the centre.
double depth_below(const mjModel& model, const mjData& data, int middle_of, int surface_of,
                   const Vec3& down) {
  const std::array<mjtNum, 3> along = {down.x(), down.y(), down.z()};
  const mjtNum* const from = entry<3>(data.geom_xpos, middle_of);
  if (model.geom_type[surface_of] == mjGEOM_MESH)
    return mj_rayMesh(&model, &data, surface_of, from, along.data());
  return mju_rayGeom(entry<3>(data.geom_xpos, surface_of), entry<9>(data.geom_xmat, surface_of),
                     entry<3>(model.geom_size, surface_of), from, along.data(),
                     model.geom_type[surface_of]);
}

/// Returns the combined thickness [m] of two geoms in contact. MuJoCo loses the contact of a
/// capsule and a box when the capsule's axis is inside the box, so the thickness of the box does
/// not count.
double thickness_of(const mjModel& model, const GeomExtent& a, const GeomExtent& b) {
  const int kinds[] = {model.geom_type[a.geom], model.geom_type[b.geom]};
  if (kinds[0] == mjGEOM_CAPSULE && kinds[1] == mjGEOM_BOX) return a.thickness;
  if (kinds[0] == mjGEOM_BOX && kinds[1] == mjGEOM_CAPSULE) return b.thickness;
  return a.thickness + b.thickness;
}

/// Returns the longest time constant [s] of any contact.
double longest_contact_time(const mjModel& model) {
  double longest = 2.0 * model.opt.timestep;
  for (int g = 0; g < model.ngeom; ++g) longest = std::max(longest, contact_time(model, g, g));
  return longest;
}

struct Fall {
  double height, thickness;  // [m] fall of the body's centre; sum of the thicknesses of both geoms
  double topple = 0.0;       // [m] fall until the body lies flat
  // [m/s] speed at the contact; largest speed that the contact can stop.
  double speed = 0.0, held = 0.0;
};

std::string warning_of(const Object& upper, const Object& lower, const GeomExtent& a,
                       const GeomExtent& b, const Fall& fall, double tick, double gravity) {
  const double share = fall.held / fall.speed;
  const double lowest = fall.held * fall.held / (2.0 * gravity) - fall.topple;
  const auto thick = [](const GeomExtent& seen) { return 1e3 * seen.thickness; };
  std::string text =
      "object '" + upper.name + "' (" + printed("%.3g mm", thick(a)) + " thick) falls " +
      printed("%.3g m", fall.height) + " onto '" + lower.name + "' (" +
      printed("%.3g mm", thick(b)) + ") and comes with " + printed("%.3g m/s", fall.speed) +
      "; with a tick of " + printed("%.3g ms", 1e3 * tick) + " they hold each other up to " +
      printed("%.3g m/s", fall.held) + ", so it may fall through; make " +
      (fall.thickness < a.thickness + b.thickness
           ? "the capsule at least " + printed("%.3g mm", 1e3 * fall.thickness / share) +
                 " thick (a box counts for nothing here)"
           : "them at least " + printed("%.3g mm", 1e3 * fall.thickness / share) +
                 " thick together");
  if (share * tick >= kLeastTick)
    text += ", or give a tick of at most " + printed("%.2g s", share * tick);
  return text + (lowest > 0.0
                     ? ", or let it begin at most " + printed("%.3g mm", 1e3 * lowest) + " above"
                     : ", or lay it flat: it topples");
}

}  // namespace

double held_speed(double thickness, double contact, double tick) {
  // A contact is a critically damped spring with the time constant `contact`, so a body penetrates
  // by speed * contact / e. The delay until the contact begins adds the distance of kTicks ticks
  // (measured, ThinContacts.*).
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

  std::vector<GeomExtent> seen;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (int g = 0; g < model.ngeom; ++g) {
    if (object_of[static_cast<std::size_t>(g)] < 0 || model.geom_type[g] == mjGEOM_HFIELD) continue;
    const double middle = up.dot(vector(entry<3>(data.geom_xpos, g)));
    const bool endless = model.geom_type[g] == mjGEOM_PLANE;
    const double half = endless ? 0.0 : half_extent_along(model, data, g, up);
    const int body = model.geom_bodyid[g];
    seen.push_back({g, middle - half, middle + half, endless ? 0.0 : 2.0 * half_thickness(model, g),
                    model.body_weldid[body] != 0 && falls(model, data, body, up), endless, false});
    lowest = std::min(lowest, middle - half);
    highest = std::max(highest, middle + half);
  }
  // Nothing in the scene can fall faster than `fastest`, so thicker bodies need no check.
  const double fastest =
      std::max(std::sqrt(2.0 * gravity * std::max(0.0, highest - lowest)), gravity * tick);
  const double slowest_hold = held_speed(1.0, longest_contact_time(model), tick);
  for (GeomExtent& s : seen) s.thin = !s.endless && slowest_hold * s.thickness < fastest;

  // Returns the height [m] of a geom's fall, down to the highest fixed geom below it.
  constexpr std::size_t kMostPairs = 20'000'000, kMostSaid = 16;
  std::size_t pairs = 0, more = 0;
  const auto drop_of = [&](const GeomExtent& a) {
    double least = std::numeric_limits<double>::infinity();
    for (const GeomExtent& b : seen) {
      ++pairs;
      if (b.falls || b.high > a.low || !meet(model, a.geom, b.geom)) continue;
      if (!b.endless && !overlap(model, data, a.geom, b.geom, up)) continue;
      least = std::min(least, a.low - b.high);
    }
    return std::isfinite(least) ? least : 0.0;
  };

  // Returns the height [m] by which the centre of a body falls until the body lies flat.
  const auto fall_of = [&](const GeomExtent& a, const GeomExtent& b) {
    const double below = depth_below(model, data, a.geom, b.geom, -up);
    if (model.geom_type[b.geom] == mjGEOM_MESH)
      pairs += static_cast<std::size_t>(model.mesh_facenum[model.geom_dataid[b.geom]]);
    const double to_highest = 0.5 * (a.low + a.high) - b.high;
    return std::max(0.0, (below >= 0.0 ? below : to_highest) - 0.5 * a.thickness);
  };

  std::vector<std::string> warnings;
  for (const GeomExtent& a : seen) {
    if (!a.falls) continue;
    for (const GeomExtent& b : seen) {
      if (++pairs > kMostPairs) break;
      if ((!a.thin && !b.thin) || b.endless || a.low < b.low || !meet(model, a.geom, b.geom))
        continue;
      const double thickness = thickness_of(model, a, b);
      if (slowest_hold * thickness >= fastest || !overlap(model, data, a.geom, b.geom, up))
        continue;
      Fall fall{.height = fall_of(a, b), .thickness = thickness};
      fall.topple = std::min(fall.height, 0.5 * (a.high - a.low - a.thickness));
      // If the lower body falls too, it may be at rest when the upper body arrives.
      if (b.falls) fall.height += drop_of(b);
      // A body that begins on another one is faster by a tick of gravity when it is found there.
      fall.speed = std::max(std::sqrt(2.0 * gravity * fall.height), gravity * tick);
      const double margin = std::max(model.geom_margin[a.geom], model.geom_margin[b.geom]);
      fall.held = held_speed(thickness + 2.0 * margin, contact_time(model, a.geom, b.geom), tick);
      if (fall.speed <= fall.held) continue;
      if (warnings.size() == kMostSaid) {
        ++more;
        continue;
      }
      const auto object = [&](const GeomExtent& s) -> const Object& {
        return objects[static_cast<std::size_t>(object_of[static_cast<std::size_t>(s.geom)])];
      };
      warnings.push_back(warning_of(object(a), object(b), a, b, fall, tick, gravity));
    }
  }
  if (more > 0)
    warnings.push_back(std::to_string(more) +
                       " more pairs of bodies are too thin for the speed at which they meet");
  return warnings;
}

std::string thin_pushed_bodies(const mjModel& model, const std::vector<Object>& objects,
                               const std::vector<int>& object_of) {
  struct Part {
    int geom;
    double thickness;  // [m]
    bool moves;
  };
  const double tick = model.opt.timestep;
  // Two bodies are thick enough if they hold a hand's speed at the longest time of a contact.
  const double thick = kPushedSpeed / held_speed(1.0, longest_contact_time(model), tick);
  std::vector<Part> thin;
  for (int g = 0; g < model.ngeom; ++g) {
    if (object_of[static_cast<std::size_t>(g)] < 0 || model.geom_type[g] == mjGEOM_HFIELD ||
        model.geom_type[g] == mjGEOM_PLANE)
      continue;
    const double thickness = 2.0 * half_thickness(model, g);
    if (thickness < thick)
      thin.push_back({g, thickness, model.body_weldid[model.geom_bodyid[g]] != 0});
  }
  // The thinnest pairs come first.
  std::ranges::sort(thin, {},
                    [](const Part& part) { return std::pair(part.thickness, part.geom); });
  constexpr std::size_t kMostPairs = 2'000'000;
  std::size_t pairs = 0, count = 0;
  double slowest = kPushedSpeed, needed = 0.0;
  const Part *first = nullptr, *second = nullptr;
  for (std::size_t i = 0; i < thin.size() && pairs < kMostPairs; ++i)
    for (std::size_t k = i + 1; k < thin.size() && pairs < kMostPairs; ++k, ++pairs) {
      const Part &a = thin[i], &b = thin[k];
      if (a.thickness + b.thickness >= thick) break;
      if ((!a.moves && !b.moves) || !meet(model, a.geom, b.geom)) continue;
      const double margin = std::max(model.geom_margin[a.geom], model.geom_margin[b.geom]);
      const double contact = contact_time(model, a.geom, b.geom);
      const double held = held_speed(a.thickness + b.thickness + 2.0 * margin, contact, tick);
      if (held >= kPushedSpeed) continue;
      ++count;
      if (first != nullptr && held >= slowest) continue;
      slowest = held;
      needed = kPushedSpeed / held_speed(1.0, contact, tick);
      first = &a;
      second = &b;
    }
  if (first == nullptr) return {};
  const auto shown = [&](const Part& part) {
    const int object = object_of[static_cast<std::size_t>(part.geom)];
    return "'" + objects[static_cast<std::size_t>(object)].name + "' (" +
           printed("%.3g mm", 1e3 * part.thickness) + " thick)";
  };
  const double share = slowest / kPushedSpeed;
  std::string text = "objects " + shown(*first) + " and " + shown(*second) + ": with a tick of " +
                     printed("%.3g ms", 1e3 * tick) + " they hold each other up to " +
                     printed("%.3g m/s", slowest) + ", so a hand that pushes one of them with " +
                     printed("%.3g m/s", kPushedSpeed) +
                     " may push it through the other; make them at least " +
                     printed("%.3g mm", 1e3 * needed) + " thick together";
  if (share * tick >= kLeastTick)
    text += ", or give a tick of at most " + printed("%.2g s", share * tick);
  if (count > 1) text += "; " + std::to_string(count - 1) + " more pairs are so thin";
  return text;
}

}  // namespace feltwire::mujoco
