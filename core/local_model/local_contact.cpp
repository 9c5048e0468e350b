#include "core/local_model/local_contact.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/local_model/patch_proxy.hpp"
#include "core/local_model/share_within.hpp"

namespace feltwire {

/// Returns the height of p above the patch, and the normal there. Let d be the vector from the
/// patch's point to p without its part along the axis. Let n be the normal and k the curvature. The
/// centre of curvature is at d = -n / k. Balls (k > 0), hollows (k < 0) and planes use the same
/// formulas:
///   normal = (n + k d) / s,   height = (2 n.d + k |d|^2) / (1 + s),   s = |n + k d|.
/// These formulas avoid cancellation, and a flat patch needs no distant centre.
Height height_above(const SurfacePatch& patch, const Vec3& moved, const Vec3& p) noexcept {
  Vec3 d = p - (patch.point + moved);
  d -= along(d, patch.axis);
  const Vec3 bent = patch.normal + patch.curvature * d;
  const double s = length(bent);
  return {(2.0 * patch.normal.dot(d) + patch.curvature * d.squaredNorm()) / (1.0 + s),
          s > 0.0 ? Vec3(bent / s) : Vec3::Zero()};
}

ContactNormals pushing_normals(const LocalModel& model, const Vec3& point) noexcept {
  ContactNormals normals;
  for (const SurfacePatch& patch : model.view()) {
    if (patch.whole) {
      if (patch.touching) normals.add(patch.normal);
      continue;
    }
    const Height above = height_above(patch, Vec3::Zero(), point);
    if (!(above.height < patch.offset)) continue;
    if (patch.joined) return {};
    if (above.normal.squaredNorm() > 0.0) normals.add(above.normal);
  }
  return normals;
}

void LocalContact::use(const PrefetchedSurfaces* surfaces) noexcept {
  if (surfaces == surfaces_) return;
  surfaces_ = surfaces;
  // The memory of a contact with the old surfaces is invalid on the new surfaces.
  adopt_whole();
}

/// Lets the contacts with prefetched surfaces continue from the contacts in the server's model.
void LocalContact::adopt_whole() noexcept {
  for (Contact& contact : contacts_)
    if (contact.whole) contact.adopted = true;
}

bool LocalContact::has_whole(const SurfacePatch& patch) const noexcept {
  return surfaces_ != nullptr && surfaces_->version() == model_.surfaces &&
         surfaces_->has(patch.object);
}

bool LocalContact::has_whole() const noexcept {
  const auto here = [&](const SurfacePatch& patch) { return patch.whole && has_whole(patch); };
  return std::ranges::any_of(model_.view(), here);
}

const LocalContact::Contact* LocalContact::contact_of(std::uint16_t object) const noexcept {
  for (int i = 0; i < count_; ++i) {
    const Contact& contact = contacts_[static_cast<std::size_t>(i)];
    if (contact.object == object) return &contact;
  }
  return nullptr;
}

/// Returns the contact with which the client continues at an object. This is the client's own
/// contact if it belongs to the object and the model still describes its face. Without contact, the
/// client's own contact is also preferred, because the model's contact is older.
LocalContact::Contact LocalContact::continued(const LocalModel& model,
                                              std::uint16_t object) const noexcept {
  const bool same_scene = model.scene == model_.scene;
  const Contact* own = last_weight_ > 0.0 && same_scene ? contact_of(object) : nullptr;
  const bool same_surfaces = model.surfaces == model_.surfaces;
  Contact others{.object = object, .memory = {}, .adopted = true};
  bool described = false;
  for (const SurfacePatch& patch : model.view()) {
    if (patch.object != object) continue;
    others.whole = patch.whole;
    if (own != nullptr && (own->whole != patch.whole || (own->whole && !same_surfaces)))
      own = nullptr;
    described |= own != nullptr && (!patch.joined || !own->memory.touching ||
                                    own->memory.feature.feature == patch.feature);
    if (patch.touching)
      others.memory = {{patch.feature, patch.normal}, true, patch.slipping, patch.anchor};
  }
  return described ? *own : others;
}

void LocalContact::take(const LocalModel& model, const Command* answered) noexcept {
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
  texture_ = answered != nullptr ? texture_of(*answered) : Texture{};
}

/// Returns the part of the server's force `answered` that the patches do not explain, at the tool
/// position model_.center of this force.
LocalContact::Texture LocalContact::texture_of(const Command& answered) const noexcept {
  Texture texture{.force = answered.elastic, .depth = 0.0};
  for (const SurfacePatch& patch : model_.view())
    // In contact with a prefetched surface, the texture cannot be separated from the surface's
    // force.
    if (patch.whole && patch.touching) return {};
  for (int i = 0; i < count_; ++i) {
    FeatureMemory entered;
    if (contacts_[static_cast<std::size_t>(i)].whole) continue;
    const std::uint16_t object = contacts_[static_cast<std::size_t>(i)].object;
    for (const SurfacePatch& patch : model_.view())
      if (patch.object == object && patch.touching) entered = {patch.feature, patch.normal};
    const PatchProxy proxy = patch_proxy(model_, object, model_.center, 0.0, entered);
    if (proxy.patch == nullptr) continue;
    const SurfacePoint& surface = proxy.surface;
    texture.force -= proxy.patch->material.stiffness * surface.depth * surface.normal;
    if (proxy.patch->rough) texture.depth = std::max(texture.depth, surface.depth);
  }
  return texture;
}

/// Returns the object's patch that the tool touched before, or else another patch of the object.
const SurfacePatch& LocalContact::patch_of(const Contact& contact) const noexcept {
  const SurfacePatch* of_object = &model_.patches[0];
  for (const SurfacePatch& patch : model_.view()) {
    if (patch.object != contact.object) continue;
    of_object = &patch;
    if (patch.feature == contact.memory.feature.feature) break;
  }
  return *of_object;
}

/// Moves the memory of a contact with its surface. The surface has moved for `age` [s] since the
/// model if the contact is adopted from the model, or else for `elapsed` [s] since the last tick.
/// For an adopted contact, the patches give the proxy at the time of the model.
void LocalContact::bring_up(Contact& contact, double age, double elapsed) const noexcept {
  ContactMemory& memory = contact.memory;
  const SurfacePatch& patch = patch_of(contact);
  if (contact.adopted) {
    const PatchProxy then = patch_proxy(model_, contact.object, model_.center, 0.0, memory.feature);
    memory.feature.proxy = then.patch != nullptr ? then.surface.point : patch.point;
    if (then.patch != nullptr) memory.feature.normal = then.surface.normal;
  }
  const Vec3 moved = (contact.adopted ? age : elapsed) * patch.velocity;
  memory.anchor += moved;
  memory.feature.proxy += moved;
  contact.adopted = false;
}

/// Computes the contact with a prefetched surface as the server's scene does. The object does not
/// move.
Command LocalContact::touch_whole(Contact& contact, const SurfacePatch& patch, const Tool& tool,
                                  WorkLimit* work) const noexcept {
  if (contact.adopted) contact.memory = surfaces_->memory_of(patch, model_.center, work);
  contact.adopted = false;
  if (is_cut(work)) return {};
  return surfaces_->touch(patch.object, patch.material, tool, contact.memory, work);
}

Command LocalContact::touch_object(Contact& contact, const Tool& tool, double age, double elapsed,
                                   double& weight, WorkLimit* work) const noexcept {
  ContactMemory& memory = contact.memory;
  if (contact.whole) {
    const SurfacePatch& patch = patch_of(contact);
    if (has_whole(patch)) return touch_whole(contact, patch, tool, work);
    weight = 0.0;  // The model refers to a surface that the client does not have.
    return {};
  }
  // An adopted contact began at the tool position of the model.
  CameFrom from = from_;
  if (memory.touching && contact.adopted) from = {true, model_.center, age};
  if (memory.touching) bring_up(contact, age, elapsed);
  const PatchProxy proxy =
      patch_proxy(model_, contact.object, tool.position, age, memory.feature, from);
  contact.rough_depth = 0.0;
  if (proxy.patch == nullptr) {
    contact = {.object = contact.object, .memory = {}};
    return {};
  }

  const SurfacePatch& patch = *proxy.patch;
  const SurfacePoint& surface = proxy.surface;
  const Vec3 point = patch.point + age * patch.velocity + patch.offset * patch.normal;
  weight = std::min(weight, share_within(length(Vec3(surface.point - point)), patch.radius));
  if (patch.faceted && memory.touching && patch.material.static_friction > 0.0)
    memory.anchor =
        carried(memory.anchor, memory.feature.proxy, memory.feature.normal, surface.normal);
  memory.feature = {.feature = patch.feature, .normal = surface.normal, .proxy = surface.point};
  Vec3 stick_force = Vec3::Zero();
  if (patch.material.static_friction > 0.0)
    stick_force = patch.material.stiffness * stick_stretch(patch.material, surface, memory);
  memory.touching = true;
  if (patch.rough) contact.rough_depth = surface.depth;
  Command command = contact_force(patch.material, surface.depth, surface.normal, stick_force,
                                  tool.velocity - patch.velocity);
  if (command.finite() && memory.anchor.allFinite()) return command;
  memory = {};  // A product of the model's numbers has overflowed.
  return {};
}

double LocalContact::weight_at(const Vec3& position) const noexcept {
  return share_within(length(Vec3(position - model_.center)), model_.reach);
}

/// Drops all results of this tick, because its work limit is reached.
LocalForce LocalContact::cut_off() noexcept {
  adopt_whole();
  from_ = {};
  last_weight_ = 0.0;
  return {.command = {}, .weight = 0.0, .cut = true};
}

LocalForce LocalContact::touch(const Tool& tool, double age, double elapsed,
                               WorkLimit* work) noexcept {
  LocalForce force;
  force.weight = weight_at(tool.position);
  from_.elapsed = elapsed;
  for (int i = 0; i < count_; ++i) {
    const Command part = touch_object(contacts_[static_cast<std::size_t>(i)], tool, age, elapsed,
                                      force.weight, work);
    if (is_cut(work)) return cut_off();
    force.command.elastic += part.elastic;
    force.command.frictional += part.frictional;
  }
  // Scale the texture's force with the depth, so that it never exceeds the normal force of the
  // surface.
  double depth = 0.0;
  for (int i = 0; i < count_; ++i)
    depth = std::max(depth, contacts_[static_cast<std::size_t>(i)].rough_depth);
  if (depth > 0.0 && texture_.depth > 0.0)
    force.command.elastic += std::min(1.0, depth / texture_.depth) * texture_.force;
  if (!force.command.finite()) force = {};
  from_ = {.known = tool.position.allFinite(), .position = tool.position, .elapsed = 0.0};
  last_weight_ = force.weight;
  return force;
}

}  // namespace feltwire
