#pragma once
// Cuts the shell of a tool with a body into parts, finest where it touches objects.

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/grid/signed_distance.hpp"
#include "core/local_model_extraction/body_points.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

/// A part of the shell near one object: the nodes or points with the indices [begin, end).
struct ShellPart {
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
  /// The loss of detail [m] if a single point replaces the part.
  double coarseness() const;
};

/// The parts of a shell at one pose. It never allocates. All arguments outlive it.
class ShellCut {
 public:
  /// Points of a model that no part has: they are for points of parts that meet another side of the
  /// solid.
  static constexpr int kSpare = kLeastBodyPoints - 1;
  /// The largest number of parts.
  static constexpr int kMost = kMaxBodyPoints - kSpare;

  /// Uses all objects except those of `known`. Cuts the shell into at most `most` parts.
  ShellCut(const PointShell& shell, const std::vector<Object>& objects, const KnownSurfaces& known,
           const Pose& tool, int most);

  const Mat3& turned() const { return turned_; }
  /// A lower bound [m] of the distance from a surface to any point outside the parts.
  double reach() const { return reach_; }
  std::span<const ShellPart> parts() const {
    return {parts_.data(), static_cast<std::size_t>(count_)};
  }

  /// The object's distance field at `arm` [m, tool frame]; its gradient in the world frame.
  FieldPoint at(std::size_t object, const Vec3& arm) const;
  /// The first point of a part, and the one after its last, in the part's shell.
  std::pair<std::uint32_t, std::uint32_t> points_of(const ShellPart& part) const;

 private:
  bool may_be_near(std::size_t object) const;
  void miss(ShellPart part);
  void measure(ShellPart& part) const;
  void offer(ShellPart part);
  bool refine();

  int most_;
  const PointShell& shell_;
  const std::vector<Object>& objects_;
  const Pose& tool_;
  Mat3 turned_;
  std::array<ShellPart, kMost> parts_{};
  int count_ = 0;
  double reach_ = kBodyReach;
};

}  // namespace feltwire
