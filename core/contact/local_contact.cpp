#include "core/contact/local_contact.hpp"

#include <algorithm>

#include "core/geometry/half_spaces.hpp"
#include "core/numeric.hpp"

namespace feltwire {
namespace {

/// 1 up to the last share of `limit`, then linearly to 0 at it and beyond. NaN gives 0.
double share_within(double distance, double limit) {
  if (!(distance < limit)) return 0.0;
  const double full = (1.0 - LocalContact::kHandOver) * limit;
  return distance <= full ? 1.0 : (limit - distance) / (limit - full);
}

bool solid(const Height& h) { return h.height < 0.0; }  // a NaN is free

/// What one object's patches come to for a tool.
struct Proxy {
  const SurfacePatch* patch = nullptr;  // the deepest, or the one it was entered by; null: free
  Vec3 beyond = Vec3::Zero();           // [m] from the tool to its proxy
  double depth = 0.0;                   // [m] |beyond|
  Vec3 normal = Vec3::Zero();           // unit

  void add(const SurfacePatch& by, const Height& h, const Vec3& undefined) {
    const Vec3 n = h.normal.isZero(0.0) ? undefined : h.normal;
    const bool first = patch == nullptr;
    const bool deeper = first || -h.height > deepest_;
    beyond -= h.height * n;
    depth = first ? -h.height : length(beyond);
    normal = first ? n : direction(beyond);
    if (deeper) {
      patch = &by;
      deepest_ = -h.height;
    }
    ++count_;
  }

  /// Not the sum, where the surfaces that meet are not at right angles: the nearest place in front
  /// of all, each taken for its tangent plane.
  void move_before(std::span<const HalfSpace> spaces, const Vec3& tool) {
    if (count_ == 0 || spaces.size() < 2) return;
    constexpr double kExact = 1e-12;  // of the depth
    const Nearest nearest = nearest_in(spaces, tool, kExact * deepest_);
    if (!nearest.found) return;
    beyond = nearest.point - tool;
    depth = length(beyond);
    normal = direction(beyond);
  }

 private:
  double deepest_ = 0.0;  // [m]
  int count_ = 0;
};

/// The joined patch whose face the proxy is on: where an obtuse edge lies between it and its foot,
/// the one beyond.
const SurfacePatch* slid(std::span<const SurfacePatch> patches, const SurfacePatch* from,
                         double age, const Vec3& tool, Height& height) {
  constexpr double kExact = 1e-9;  // of the depth: at right angles nothing is beyond
  const Vec3 foot = tool - height.height * height.normal;
  const SurfacePatch* to = from;
  double highest = -kExact * height.height;
  for (const SurfacePatch& patch : patches) {
    if (!patch.joined || patch.object != from->object || &patch == from) continue;
    const double above = height_above(patch, age * patch.velocity, foot).height;
    if (!(above > highest)) continue;
    highest = above;
    to = &patch;
  }
  if (to != from) height = height_above(*to, age * to->velocity, tool);
  return to;
}

}  // namespace

/// With d from the patch's point to p (less its part along the axis), n the normal and k the
/// curvature, the centre of curvature is at d = -n / k, and for balls (k > 0), hollows (k < 0) and
/// planes alike
///   normal = (n + k d) / s,   height = (2 n.d + k |d|^2) / (1 + s),   s = |n + k d|.
/// Nothing cancels in it: a flat patch needs no far centre.
Height height_above(const SurfacePatch& patch, const Vec3& moved, const Vec3& p) noexcept {
  Vec3 d = p - (patch.point + moved);
  d -= along(d, patch.axis);
  const Vec3 bent = patch.normal + patch.curvature * d;
  const double s = length(bent);
  return {(2.0 * patch.normal.dot(d) + patch.curvature * d.squaredNorm()) / (1.0 + s),
          s > 0.0 ? Vec3(bent / s) : Vec3::Zero()};
}

const LocalContact::Contact* LocalContact::contact_of(std::uint16_t object) const noexcept {
  for (int i = 0; i < count_; ++i) {
    const Contact& contact = contacts_[static_cast<std::size_t>(i)];
    if (contact.object == object) return &contact;
  }
  return nullptr;
}

/// The memory to go on with: this side's own where it follows the object (a free one too: what the
/// model says of touching is older) and its face is still described, else the model's.
LocalContact::Contact LocalContact::continued(const LocalModel& model,
                                              std::uint16_t object) const noexcept {
  const Contact* own = last_weight_ > 0.0 ? contact_of(object) : nullptr;
  Contact others{.object = object, .memory = {}, .adopted = true};
  bool described = false;
  for (const SurfacePatch& patch : model.view()) {
    if (patch.object != object) continue;
    described |= own != nullptr && (!patch.joined || !own->memory.touching ||
                                    own->memory.feature.feature == patch.feature);
    if (patch.touching)
      others.memory = {{patch.feature, patch.normal}, true, patch.slipping, patch.anchor};
  }
  return described ? *own : others;
}

void LocalContact::take(const LocalModel& model) noexcept {
  std::array<Contact, kMaxPatches> contacts{};
  int count = 0;
  for (const SurfacePatch& patch : model.view()) {
    const auto begin = contacts.begin(), end = begin + count;
    if (std::any_of(begin, end, [&](const Contact& c) { return c.object == patch.object; }))
      continue;
    contacts[static_cast<std::size_t>(count++)] = continued(model, patch.object);
  }
  contacts_ = contacts;
  count_ = count;
  model_ = model;
  for (SurfacePatch& patch : model_.patches) {
    patch.normal = direction(patch.normal);
    patch.axis = direction(patch.axis);
  }
}

Command LocalContact::touch_object(Contact& contact, const Tool& tool, double age, double elapsed,
                                   double& weight) const noexcept {
  ContactMemory& memory = contact.memory;
  Proxy proxy;
  const SurfacePatch* joined = nullptr;  // the one of the joined that pushes
  Height joined_height;
  bool inside_joined = true;
  std::array<HalfSpace, kMaxPatches> spaces;
  std::size_t hollow = 0;  // of them
  for (const SurfacePatch& patch : model_.view()) {
    if (patch.object != contact.object) continue;
    const Height h = height_above(patch, age * patch.velocity, tool.position);
    const Vec3& undefined = memory.feature.feature != 0 ? memory.feature.normal : patch.normal;
    if (!patch.joined) {
      if (solid(h)) proxy.add(patch, h, undefined);
      const Vec3 normal = h.normal.isZero(0.0) ? undefined : h.normal;
      spaces[hollow++] = {normal, normal.dot(tool.position) - h.height};
      continue;
    }
    inside_joined &= solid(h);
    const bool entered = memory.feature.feature == patch.feature;
    const bool held = joined != nullptr && memory.feature.feature == joined->feature;
    // By the nearest face when it enters, and then by the same until it leaves (shapes.cpp).
    if (joined == nullptr || entered || (!held && h.height > joined_height.height)) {
      joined = &patch;
      joined_height = h;
    }
  }
  if (joined == nullptr) proxy.move_before({spaces.data(), hollow}, tool.position);
  if (joined != nullptr && inside_joined)
    joined = slid(model_.view(), joined, age, tool.position, joined_height);
  if (joined != nullptr && inside_joined)
    proxy.add(*joined, joined_height,
              memory.feature.feature != 0 ? memory.feature.normal : joined->normal);
  if (proxy.patch == nullptr) {
    contact = {.object = contact.object, .memory = {}};
    return {};
  }

  const SurfacePatch& patch = *proxy.patch;
  const SurfacePoint surface{tool.position + proxy.beyond, proxy.normal, proxy.depth};
  const Vec3 point = patch.point + age * patch.velocity;
  weight = std::min(weight, share_within(length(Vec3(surface.point - point)), patch.radius));
  memory.feature = {patch.feature, surface.normal};
  memory.anchor += (contact.adopted ? age : elapsed) * patch.velocity;
  contact.adopted = false;
  Vec3 stick_force = Vec3::Zero();
  if (patch.material.static_friction > 0.0)
    stick_force = patch.material.stiffness * stick_stretch(patch.material, surface, memory);
  memory.touching = true;
  Command command = contact_force(patch.material, surface.depth, surface.normal, stick_force,
                                  tool.velocity - patch.velocity);
  if (command.finite() && memory.anchor.allFinite()) return command;
  memory = {};  // a model beyond what products can hold
  return {};
}

double LocalContact::weight_at(const Vec3& position) const noexcept {
  return share_within(length(Vec3(position - model_.center)), model_.reach);
}

LocalForce LocalContact::touch(const Tool& tool, double age, double elapsed) noexcept {
  LocalForce force;
  force.weight = weight_at(tool.position);
  for (int i = 0; i < count_; ++i) {
    const Command part =
        touch_object(contacts_[static_cast<std::size_t>(i)], tool, age, elapsed, force.weight);
    force.command.elastic += part.elastic;
    force.command.frictional += part.frictional;
  }
  if (!force.command.finite()) force = {};
  last_weight_ = force.weight;
  return force;
}

}  // namespace feltwire
