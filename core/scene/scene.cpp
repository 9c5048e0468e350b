#include "core/scene/scene.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

/// `least` in words, with the unit in its brackets.
MaybeViolation out_of_range(const char* field, double value, const std::string& least, double most,
                            const std::string& unit) {
  if (std::isnan(value)) return Violation{field, "is not given; give a number " + least + unit};
  if (value > most)
    return Violation{field, "must be at most " + number_text(most) + unit + ", is " +
                                number_text(value) + "; check the unit"};
  return Violation{
      field, "must be " + least + unit + ", is " + number_text(value) + "; give a larger number"};
}

}  // namespace

MaybeViolation positive(const char* field, double value, double most, const char* unit) {
  if (value > 0.0 && value <= most) return std::nullopt;
  return out_of_range(field, value, "above zero", most, unit);
}

MaybeViolation not_negative(const char* field, double value, double most, const char* unit) {
  if (value >= 0.0 && value <= most) return std::nullopt;
  return out_of_range(field, value, "at least zero", most, unit);
}

MaybeViolation first(std::initializer_list<MaybeViolation> found) {
  for (const MaybeViolation& f : found)
    if (f) return f;
  return std::nullopt;
}

namespace {

struct ShapeRules {
  MaybeViolation operator()(const Primitive auto& solid) const {
    MaybeViolation violation;
    solid.lengths(solid, [&](const Length& length, double value) {
      if (violation) return;
      const double given = value / length.share, most = std::min(length.most, kMaxLength);
      violation = length.may_be_zero ? not_negative(length.name, given, most, " [m]")
                                     : positive(length.name, given, most, " [m]");
    });
    return violation;
  }
  MaybeViolation operator()(const Mesh& m) const {
    if (!m.surface) return Violation{"mesh", "has no surface; load one"};
    const TriangleMesh& mesh = m.surface->mesh();
    const double size = 2.0 * mesh.half_extents().maxCoeff();
    if (!(size <= kMaxLength && mesh.origin().cwiseAbs().maxCoeff() <= kMaxLength))
      return Violation{"scale", "makes a surface of " + number_text(size) + " m at " +
                                    number_text(mesh.origin().cwiseAbs().maxCoeff()) +
                                    " m from the origin; check the unit"};
    return first({positive("scale: the size of the surface", size, kMaxLength, " [m]"),
                  not_negative("radius", m.surface->options().radius, kMaxLength, " [m]")});
  }
  MaybeViolation operator()(const Grid& g) const {
    if (g.field) return std::nullopt;
    return Violation{"grid", "has no field; sample a solid"};
  }
};

MaybeViolation coordinate(const char* field, double value) {
  if (std::abs(value) <= kMaxLength) return std::nullopt;
  return Violation{field, "must lie within " + number_text(kMaxLength) + " m of the origin, is " +
                              number_text(value) + "; give metres"};
}

MaybeViolation coordinates(const Vec3& position) {
  return first({coordinate("position.x", position.x()), coordinate("position.y", position.y()),
                coordinate("position.z", position.z())});
}

Requirements required_by(const std::vector<Object>& objects, const std::vector<Guide>& guides) {
  Requirements r;
  for (const Object& o : objects) {
    r.friction |= o.material.static_friction > 0.0;
    r.velocity |= o.material.damping > 0.0 || o.material.viscous_friction > 0.0;
    r.stiffness = std::max(r.stiffness, o.material.stiffness);
  }
  r.guides = !guides.empty();
  for (const Guide& guide : guides) {
    r.velocity |= needs_velocity(guide);
    r.stiffness = std::max(r.stiffness, stiffness(guide));
  }
  return r;
}

}  // namespace

void make_unit(Quaternion& orientation) {
  auto& coefficients = orientation.coeffs();
  coefficients /= coefficients.cwiseAbs().maxCoeff();  // no square over- or underflows after this
  coefficients.normalize();
}

std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

MaybeViolation check(const Shape& shape) { return std::visit(ShapeRules{}, shape); }

MaybeViolation check(const Material& m) {
  if (auto violation =
          first({positive("stiffness", m.stiffness, kMaxStiffness, " [N/m]"),
                 not_negative("damping", m.damping, kMaxDamping, " [N s/m]"),
                 not_negative("static_friction", m.static_friction, kMaxFrictionCoefficient, ""),
                 not_negative("dynamic_friction", m.dynamic_friction, kMaxFrictionCoefficient, ""),
                 not_negative("viscous_friction", m.viscous_friction, kMaxDamping, " [N s/m]")}))
    return violation;
  if (m.dynamic_friction <= m.static_friction) return std::nullopt;
  return Violation{"dynamic_friction",
                   "must not exceed static_friction = " + number_text(m.static_friction) + ", is " +
                       number_text(m.dynamic_friction) + "; lower it or raise the other"};
}

MaybeViolation check(const Pose& pose) {
  if (auto violation = coordinates(pose.position)) return violation;
  const double largest = pose.orientation.coeffs().cwiseAbs().maxCoeff();
  if (pose.orientation.coeffs().allFinite() && largest > 0.0) return std::nullopt;
  return Violation{"orientation",
                   "is no rotation: all of [w, x, y, z] are zero or one is not finite; "
                   "leave it out or give a quaternion"};
}

MaybeViolation check(const Start& start) {
  if (auto violation = coordinates(start.position)) return violation;
  if (start.normal.allFinite() && length(start.normal) > 0.0) return std::nullopt;
  return Violation{"normal",
                   "has no direction: all of [x, y, z] are zero; leave it out or give a normal"};
}

MaybeViolation broken_name(const std::string& name) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  if (std::any_of(name.begin(), name.end(), is_control))
    return Violation{"name", "holds a line break or another control character; remove it"};
  if (!name.empty() && name.size() <= kMaxNameLength) return std::nullopt;
  return Violation{"name", "must be 1 to " + std::to_string(kMaxNameLength) + " bytes long, is " +
                               std::to_string(name.size()) + "; choose a short name"};
}

Scene::Scene(std::string name, std::vector<Object> objects, const Start& start,
             std::vector<Guide> guides)
    : name_(std::move(name)),
      objects_(std::move(objects)),
      guides_(std::move(guides)),
      start_(start) {
  if (auto violation = broken_name(name_)) refuse("scene", *violation);
  if (auto violation = check(start_)) refuse("start", *violation);
  start_.normal = direction(start_.normal);
  if (objects_.empty() && guides_.empty())
    refuse("scene", {"objects", "there is none to touch, and no guide; add at least one"});
  std::set<std::string> names;
  for (Object& object : objects_) {
    const std::string whose = "object '" + object.name + "'";
    if (auto violation = broken_name(object.name)) refuse(whose, *violation);
    if (!names.insert(object.name).second)
      refuse(whose, {"name", "stands twice in the scene; rename one"});
    if (auto violation = check(object.shape)) refuse(whose, *violation);
    if (auto violation = check(object.material)) refuse(whose, *violation);
    if (auto violation = check(object.pose)) refuse(whose, *violation);
    make_unit(object.pose.orientation);
  }
  names.clear();
  for (Guide& guide : guides_) {
    const std::string whose = "guide '" + guide.name + "'";
    if (auto violation = broken_name(guide.name)) refuse(whose, *violation);
    if (!names.insert(guide.name).second)
      refuse(whose, {"name", "stands twice in the scene; rename one"});
    if (auto violation = check(guide)) refuse(whose, *violation);
    make_unit(guide.pose.orientation);
  }
  requirements_ = required_by(objects_, guides_);
  still_ = objects_.size();
  find_by_tree();
}

void Scene::set_mechanism(std::shared_ptr<const Mechanism> mechanism) {
  if (mechanism != nullptr && mechanism->still() + mechanism->parts().size() != objects_.size())
    refuse(
        "scene",
        {"mechanism",
         "was compiled for " + std::to_string(mechanism->still() + mechanism->parts().size()) +
             " objects, here are " + std::to_string(objects_.size()) + "; compile it for these"});
  mechanism_ = std::move(mechanism);
  if (mechanism_ != nullptr)
    warnings_.insert(warnings_.end(), mechanism_->warnings().begin(), mechanism_->warnings().end());
  still_ = mechanism_ != nullptr ? mechanism_->still() : objects_.size();
  find_by_tree();
}

TouchMemory Scene::memory() const {
  TouchMemory memory(objects_.size());
  if (!broad_phase_.in_use()) return memory;
  memory.live_.reserve(objects_.size());
  memory.asked_.reserve(2 * objects_.size());
  return memory;
}

/// Of the objects that the tool's way meets or that hold it; in the order of the objects, so that
/// the sum has the same bits whatever the tree looks like.
Command Scene::touch_near(const Tool& tool, TouchMemory& memory) const noexcept {
  const Vec3 from = memory.tracked_ ? memory.position_ : tool.position;
  std::vector<std::uint32_t>& asked = memory.asked_;
  asked.assign(memory.live_.begin(), memory.live_.end());
  const auto ask = [&](std::uint32_t i) {
    if (asked.size() == asked.capacity()) [[unlikely]]
      return;  // never: each comes twice at most
    asked.push_back(i);
  };
  for (const std::uint32_t i : broad_phase_.everywhere()) ask(i);
  const auto known = static_cast<std::ptrdiff_t>(memory.live_.size());
  broad_phase_.along(from, tool.position, ask);
  // Whose memory is not of the sample before is told where the tool comes from.
  const auto is_live = [&](std::uint32_t i) {
    return std::find(asked.begin(), asked.begin() + known, i) != asked.begin() + known;
  };
  for (std::size_t n = static_cast<std::size_t>(known); n < asked.size(); ++n) {
    const Object& object = objects_[asked[n]];
    if (!memory.tracked_ || is_live(asked[n]) || !follows_way(object.shape, object.felt_from))
      continue;
    approach_from(object.shape, object.pose.orientation.conjugate() * (from - object.pose.position),
                  memory[asked[n]].feature);
  }
  std::sort(asked.begin(), asked.end());
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());

  Command sum;
  memory.live_.clear();
  for (const std::uint32_t i : asked) {
    add_touch(objects_[i], tool, memory[i], tool_.radius, sum);
    if (memory[i].touching || memory[i].feature.side != 0)
      memory.live_.push_back(i);
    else
      memory[i] = {};
  }
  memory.tracked_ = true;
  memory.position_ = tool.position;
  return sum;
}

void Scene::add_guides(const Tool& tool, Command& sum) const noexcept {
  Command guides;
  for (const Guide& guide : guides_) {
    const Command part = guide_force(guide, tool);
    guides.elastic += part.elastic;
    guides.frictional += part.frictional;
  }
  if (objects_.empty()) {
    sum.elastic += guides.elastic;
    sum.frictional += guides.frictional;
    return;
  }
  const Vec3 all = guides.force();
  if (all.isZero(0.0)) return;
  sum.frictional += all;
  // Guides that pull harder into a surface than it pushes would make a contact pull, which no bound
  // lets through.
  if (sum.force().dot(sum.elastic) > 0.0) return;
  sum.frictional += sum.elastic;
  sum.elastic.setZero();
}

Command Scene::touch(const Pose& device, const Vec3& velocity, double elapsed,
                     BodyMemory& memory) const noexcept {
  Command command = step_body(*tool_.body, objects_, device, elapsed, memory).command;
  add_guides({device.position, velocity}, command);
  return command.finite() ? command : Command{};
}

Command Scene::touch(const Tool& tool, TouchMemory& memory, std::size_t count) const noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() || memory.size() != objects_.size())
      [[unlikely]]
    return {};
  Command sum;
  const bool by_tree = broad_phase_.in_use();
  if (by_tree) sum = touch_near(tool, memory);
  for (std::size_t i = by_tree ? still_ : 0; i < count; ++i)
    add_touch(objects_[i], tool, memory[i], tool_.radius, sum);
  return sum;
}

}  // namespace feltwire
