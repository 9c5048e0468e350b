#include "core/local_model_extraction/body_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/local_model_extraction/shell_cut.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

constexpr double kLooked = 2e-3;  // [m] The points of a nearer part are examined one by one.
// [m] least distance within which a model that omits points is complete.
constexpr double kLeastReach = 1e-2;

/// Sums over points near about the same plane. `arm` (from the tool's origin) is in the tool frame,
/// and the normals are in the world frame.
struct Gathered {
  // `distance` and `least`: [m].
  double count = 0.0, distance = 0.0, least = std::numeric_limits<double>::infinity();
  double pushed = 0.0, squares = 0.0;
  Vec3 arm = Vec3::Zero(), normal = Vec3::Zero(), pressure = Vec3::Zero();
  Mat3 arms = Mat3::Zero();

  void add(const Vec3& arm_of, const FieldPoint& field) {
    count += 1.0;
    distance += field.distance;
    least = std::min(least, field.distance);
    const double load = std::max(0.0, -field.distance) * length(field.gradient);
    pushed += load;
    pressure += load * arm_of;
    squares += field.gradient.squaredNorm();
    arm += arm_of;
    normal += field.gradient;
    arms += arm_of * arm_of.transpose();
  }
  Vec3 center() const { return arm / count; }
  Mat3 spread() const { return arms / count - center() * center().transpose(); }
};

/// Returns the depth [m] of the centre of a part with evenly spread points. `half` [m] is half the
/// difference between the greatest and the least depth, and `mean` [m] is the mean penetration.
double depth_for(double mean, double half) {
  if (mean >= half) return mean;
  return 2.0 * std::sqrt(half * mean) - half;  // (depth + half)^2 / (4 half) = mean
}

/// Turns parts into points and patches.
struct Builder {
  const BodyTool& tool;
  const std::vector<Object>& objects;
  const ShellCut& cut;
  BodyModel& model;
  int most = kMaxBodyPoints;
  const World* world = nullptr;  // null if no object moves
  std::array<std::uint8_t, kMaxBodyPatches> sides{};

  /// Returns the index of the object's side with this normal: the signed axis of the object frame
  /// nearest to the normal.
  std::uint8_t side_of(std::size_t object, const Vec3& normal) const {
    const Vec3 n = objects[object].pose.orientation.conjugate() * normal;
    Eigen::Index axis;
    n.cwiseAbs().maxCoeff(&axis);
    return static_cast<std::uint8_t>(2 * axis + (n[axis] < 0.0 ? 1 : 0));
  }

  /// Returns the factor that scales the force of an object.
  double trust(std::size_t object) const { return world != nullptr ? world->trust(object) : 1.0; }

  /// Returns the index of the patch for this normal at `arm` [m, tool frame]. If no patch is free,
  /// returns the patch of another side of the object, or the last patch.
  std::uint8_t patch_of(std::size_t object, const Vec3& normal, const Vec3& arm) {
    const std::uint8_t side = side_of(object, normal);
    std::uint8_t other = kMaxBodyPatches - 1;
    const auto count = static_cast<std::uint8_t>(model.patch_count);
    for (std::uint8_t i = 0; i < count; ++i) {
      if (model.patches[i].object != object) continue;
      if (sides[i] == side) return i;
      other = i;
    }
    if (model.patch_count == kMaxBodyPatches) return other;
    const auto made = static_cast<std::uint8_t>(model.patch_count++);
    const Material& m = objects[object].material;
    BodyPatch& patch = model.patches[made];
    patch.static_friction = m.static_friction;
    patch.dynamic_friction = m.dynamic_friction;
    patch.viscous_friction = trust(object) * m.viscous_friction;
    patch.damping_time = m.damping / m.stiffness;
    patch.object = static_cast<std::uint16_t>(object);
    if (world != nullptr)
      patch.velocity =
          world->velocity_at(object, model.tool.position + model.tool.orientation * arm);
    sides[made] = side;
    return made;
  }

  bool add(std::size_t object, const Gathered& points) {
    const Vec3 normal = direction(points.normal);
    if (!(points.squares > 0.0) || normal.isZero(0.0)) return true;
    if (model.count == most) return false;
    const double share =
        tool.shell().area / (tool.contact_area() * static_cast<double>(tool.shell().points.size()));
    BodyPoint point{
        .arm = points.center(),
        .spread = points.spread(),
        .normal = normal,
        .distance = points.distance / points.count,
        .stiffness = trust(object) * objects[object].material.stiffness * share * points.squares,
        .patch = patch_of(object, normal, points.center())};
    const Mat3 turned = cut.turned();
    const Vec3 n = turned.transpose() * normal;
    const double half = std::sqrt(3.0 * std::max(0.0, n.dot(point.spread * n)));
    // Give the point the contact force and the centre of pressure that the scene computes.
    if (points.pushed > 0.0) {
      point.distance = -depth_for(points.pushed / points.squares, half);
      const PressedPart in = pressed_part(-point.distance, half);
      const Vec3 spread = point.spread * n;
      Vec3 pressed = point.arm;
      if (half > 0.0) pressed -= in.moment / in.depth / (half * half / 3.0) * spread;
      point.arm += points.pressure / points.pushed - pressed;
    } else {
      // On a curved solid, the plane would otherwise touch before the nearest point.
      point.distance = std::max(point.distance, points.least + half);
    }
    model.points[static_cast<std::size_t>(model.count++)] = point;
    return true;
  }

  /// A group of points of one part. Group 0 has the points about one plane: the plane that pushes
  /// most or, if no plane pushes, the nearest plane. Each other group has the points that meet one
  /// side of the object.
  struct Group {
    Gathered points;
    std::size_t object = 0;
  };
  static constexpr std::size_t kSides = 7;

  void gather(const ShellPart& part, std::span<Group> groups) const {
    // Least cosine of the angle between a normal and the plane's normal.
    constexpr double kOneSide = 0.9;
    const auto [begin, end] = cut.points_of(part);
    Vec3 pushed = Vec3::Zero(), nearest = Vec3::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = begin; i < end; ++i) {
      const FieldPoint field = cut.at(part.object, part.shell->points[i]);
      if (field.distance < 0.0) pushed -= field.distance * field.gradient;
      if (field.distance < least) {
        least = field.distance;
        nearest = field.gradient;
      }
    }
    const Vec3 normal = direction(pushed.isZero(0.0) ? nearest : pushed);
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vec3& arm = part.shell->points[i];
      const FieldPoint field = cut.at(part.object, arm);
      const bool main = field.gradient.dot(normal) >= kOneSide * length(field.gradient);
      Group& group = groups[main ? 0U : 1U + side_of(part.object, field.gradient)];
      group.object = part.object;
      group.points.add(arm, field);
    }
  }

  bool far(const ShellPart& part) {
    const auto [begin, end] = cut.points_of(part);
    Gathered points;
    for (std::uint32_t i = begin; i < end; ++i) points.add(part.shell->points[i], {});
    const FieldPoint field = cut.at(part.object, points.center());
    points.distance = points.count * field.distance;
    points.least = part.nearest();
    points.normal = field.gradient;
    points.squares = points.count * field.gradient.squaredNorm();
    return add(part.object, points);
  }

  void build() {
    std::array<Group, ShellCut::kMost * kSides> groups;
    const auto parts = cut.parts();
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].nearest() < kLooked)
        gather(parts[i], std::span(groups).subspan(kSides * i, kSides));
    // Sort the groups by force. Then sort groups of equal force by distance.
    std::array<const Group*, ShellCut::kMost * kSides> order{};
    std::size_t count = 0;
    for (const Group& group : groups)
      if (group.points.count > 0.0) order[count++] = &group;
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
              [](const Group* a, const Group* b) {
                if (a->points.pushed != b->points.pushed)
                  return a->points.pushed > b->points.pushed;
                if (a->points.least != b->points.least) return a->points.least < b->points.least;
                return a < b;
              });
    for (std::size_t i = 0; i < count; ++i)
      if (!add(order[i]->object, order[i]->points))
        model.reach = std::min(model.reach, std::max(kLeastReach, order[i]->points.least));
    for (const ShellPart& part : parts)
      if (!(part.nearest() < kLooked) && !far(part))
        model.reach = std::min(model.reach, std::max(kLeastReach, part.nearest()));
  }
};

/// Builds the model of a tool with a body. `objects` are the view's objects at their current poses.
/// `world` gives their velocities and may be null.
BodyModel model_of(const ToolView& view, const std::vector<Object>& objects, const Pose& device,
                   const BodyMemory& memory, std::uint32_t version, const KnownSurfaces& known,
                   int most, const World* world = nullptr) noexcept {
  BodyModel model;
  if (!view.tool().body || !memory.placed) return model;
  const BodyTool& tool = *view.tool().body;
  if (tool.inertia().mass > 0.0 && version == 0) return model;
  if (most < kLeastBodyPoints) return model;
  most = std::min(most, kMaxBodyPoints);
  const ShellCut cut(tool.shell(), objects, known, memory.pose, most - ShellCut::kSpare);
  model.solids = version;
  model.tool = memory.pose;
  model.coupling = tool.coupling();
  model.radius = tool.shell().radius;
  model.slipping = memory.slipping;
  model.reach = cut.reach();
  // Guides limit the reach, because a model cannot describe them.
  for (const Guide& guide : view.guides())
    model.reach = std::min(model.reach, begins(guide, device.position));
  Builder{tool, objects, cut, model, most, world}.build();
  model.reach = std::max(0.0, model.reach);
  model.turn = model.reach / model.radius;
  return model;
}

}  // namespace

BodyModel body_model(const ToolView& view, const Pose& device, const BodyMemory& memory,
                     std::uint32_t version, const KnownSurfaces& known, int most) noexcept {
  return model_of(view, view.objects(), device, memory, version, known, most);
}

BodyModel body_model(const World& world, const Pose& device, const BodyMemory& memory,
                     std::size_t held, std::uint32_t version, const KnownSurfaces& known,
                     int most) noexcept {
  return model_of(world.view(held), world.objects(held), device, memory, version, known, most,
                  &world);
}

}  // namespace feltwire
