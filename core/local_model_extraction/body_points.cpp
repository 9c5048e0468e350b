#include "core/local_model_extraction/body_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kMostNumbered = std::numeric_limits<std::uint16_t>::max();
/// Largest number of parts into which the point shell is split. The other kSpare points of the
/// model are for points of these parts that meet another side of the solid.
constexpr int kSpare = kLeastBodyPoints - 1;
constexpr int kParts = kMaxBodyPoints - kSpare;

constexpr double kLooked = 2e-3;  // [m] The points of a nearer part are examined one by one.
// [m] least distance within which a model that omits points is complete.
constexpr double kLeastReach = 1e-2;

/// A part of the shell near one object: the nodes or points with the indices [begin, end).
struct Part {
  std::size_t object = 0;
  // Points of one of the tool's sides (PointShell::sides), or of the whole tool.
  const PointShell* shell = nullptr;
  bool of_points = false;
  std::uint32_t begin = 0, end = 0;
  Vec3 center = Vec3::Zero();  // [m, tool frame] centre of the bounding ball
  double radius = 0.0;         // [m] radius of the bounding ball
  double distance = 0.0;       // [m] distance from the centre to the surface

  double nearest() const { return distance - radius; }  // [m] lower bound of the points' distances
  bool single() const { return of_points && end - begin == 1; }
  /// Returns the loss of detail [m] if a single point replaces the part.
  double coarseness() const {
    if (single()) return 0.0;
    const double far = std::clamp(nearest() / kBodyReach, 0.0, 1.0);
    return radius * std::pow(1.0 - far, 4);
  }
};

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

class Cut {
 public:
  const Mat3& turned() const { return turned_; }
  /// Uses all objects except those of `known`. Splits the shell into at most `most` parts.
  Cut(const PointShell& shell, const std::vector<Object>& objects, const KnownSurfaces& known,
      const Pose& tool, int most)
      : most_(most),
        shell_(shell),
        objects_(objects),
        known_(known),
        tool_(tool),
        turned_(tool.orientation.toRotationMatrix()) {}

  /// Returns a lower bound [m] of the distance from a surface to any point outside the chosen
  /// parts.
  double reach() const { return reach_; }
  std::span<const Part> parts() const { return {parts_.data(), static_cast<std::size_t>(count_)}; }

  void all() {
    if (std::ranges::count(known_, true) == std::ssize(objects_)) reach_ = kModelReach;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if ((i < known_.size() && known_[i]) || !may_be_near(i)) continue;
      const auto side = [&](const PointShell& shell) {
        const Part root{.object = i, .shell = &shell, .begin = 0, .end = 1};
        if (i <= kMostNumbered)
          offer(root);
        else
          miss(root);
      };
      std::ranges::for_each(shell_.sides, side);
      if (shell_.sides.empty()) side(shell_);
    }
    while (refine()) {
    }
  }

  FieldPoint at(std::size_t object, const Vec3& arm) const {
    const Object& o = objects_[object];
    const Quaternion to_object = o.pose.orientation.conjugate();
    FieldPoint field = signed_distance(
        o.shape, o.felt_from, to_object * (tool_.position + turned_ * arm - o.pose.position));
    field.gradient = o.pose.orientation * field.gradient;
    return field;
  }

  std::pair<std::uint32_t, std::uint32_t> points_of(const Part& part) const {
    if (part.of_points) return {part.begin, part.end};
    return {part.shell->nodes[part.begin].begin, part.shell->nodes[part.end - 1].end};
  }

 private:
  /// Returns true if a point of the shell may be within reach_ of an object. This test excludes
  /// most objects.
  bool may_be_near(std::size_t object) const {
    const ShellNode& whole = shell_.nodes.front();
    return at(object, whole.center).distance - whole.radius < reach_;
  }

  void miss(Part part) {
    measure(part);
    reach_ = std::min(reach_, part.nearest());
  }

  /// Computes the bounding ball of a part and the distance of its centre from the surface.
  void measure(Part& part) const {
    const auto n = static_cast<double>(part.end - part.begin);
    part.center.setZero();
    part.radius = 0.0;
    for (std::uint32_t i = part.begin; i < part.end; ++i)
      part.center += (part.of_points ? part.shell->points[i] : part.shell->nodes[i].center) / n;
    for (std::uint32_t i = part.begin; i < part.end; ++i) {
      const double reaches = part.of_points ? (part.shell->points[i] - part.center).norm()
                                            : (part.shell->nodes[i].center - part.center).norm() +
                                                  part.shell->nodes[i].radius;
      part.radius = std::max(part.radius, reaches);
    }
    part.distance = at(part.object, part.center).distance;
  }

  /// Adds a part if it is within reach_, the distance within which the model is complete. If there
  /// are too many parts, the farthest part is dropped and limits this distance.
  void offer(Part part) {
    measure(part);
    if (!(part.nearest() < reach_)) return;
    if (count_ == most_) {
      const auto end = parts_.begin() + count_;
      const auto farthest = std::max_element(parts_.begin(), end, [](const Part& a, const Part& b) {
        return a.nearest() < b.nearest();
      });
      if (farthest->nearest() < part.nearest()) {
        reach_ = std::min(reach_, part.nearest());
        return;
      }
      reach_ = std::min(reach_, farthest->nearest());
      *farthest = part;
      return;
    }
    parts_[static_cast<std::size_t>(count_++)] = part;
  }

  /// Splits a part into two parts. Returns false if that is impossible.
  bool halves(const Part& part, Part& low, Part& high) const {
    Part whole = part;
    while (!whole.of_points && whole.end - whole.begin == 1) {
      const ShellNode& node = whole.shell->nodes[whole.begin];
      whole.of_points = node.children == 0;
      whole.begin = whole.of_points ? node.begin : node.child;
      whole.end = whole.of_points ? node.end : node.child + node.children;
    }
    if (whole.end - whole.begin < 2) return false;
    low = high = whole;
    low.end = high.begin = whole.begin + (whole.end - whole.begin + 1) / 2;
    return true;
  }

  /// Splits the coarsest part in two. Returns false if no part may be split.
  bool refine() {
    constexpr double kFine = 1e-5;  // [m] A part with a smaller coarseness is not split.
    const auto begin = parts_.begin(), end = begin + count_;
    const auto coarsest = std::max_element(
        begin, end, [](const Part& a, const Part& b) { return a.coarseness() < b.coarseness(); });
    if (coarsest == end || !(coarsest->coarseness() > kFine)) return false;
    Part low, high;
    if (!halves(*coarsest, low, high)) return false;
    measure(low);
    measure(high);
    const bool keeps_low = low.nearest() < reach_, keeps_high = high.nearest() < reach_;
    if (keeps_low && keeps_high && count_ == most_) return false;
    *coarsest = keeps_low ? low : high;
    if (keeps_low && keeps_high) parts_[static_cast<std::size_t>(count_++)] = high;
    if (!keeps_low && !keeps_high) *coarsest = parts_[static_cast<std::size_t>(--count_)];
    return true;
  }

  int most_;
  const PointShell& shell_;
  const std::vector<Object>& objects_;
  const KnownSurfaces& known_;
  const Pose& tool_;
  Mat3 turned_;
  std::array<Part, kParts> parts_{};
  int count_ = 0;
  double reach_ = kBodyReach;
};

/// Turns parts into points and patches.
struct Builder {
  const BodyTool& tool;
  const std::vector<Object>& objects;
  const Cut& cut;
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

  void gather(const Part& part, std::span<Group> groups) const {
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

  bool far(const Part& part) {
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
    std::array<Group, kParts * kSides> groups;
    const auto parts = cut.parts();
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].nearest() < kLooked)
        gather(parts[i], std::span(groups).subspan(kSides * i, kSides));
    // Sort the groups by force. Then sort groups of equal force by distance.
    std::array<const Group*, kParts * kSides> order{};
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
    for (const Part& part : parts)
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
  Cut cut(tool.shell(), objects, known, memory.pose, most - kSpare);
  cut.all();
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
