#pragma once
// Which of the objects that move a tool could meet: a list of those near it, which holds until tool
// and objects have come far enough together (Verlet 1967, "Computer 'experiments' on classical
// fluids"). So a scene of thousands costs what the few near the tool cost.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"

namespace feltwire {

/// Of one tool. One that has not looked yet knows of none, and its list holds nowhere.
struct NeighbourList {
  std::vector<std::uint32_t> parts;                         // rising
  Vec3 from = Vec3::Zero();                                 // [m] where the tool was
  double until = -std::numeric_limits<double>::infinity();  // [m] of all that has moved

  bool known() const { return until > -std::numeric_limits<double>::infinity(); }
  void forget() noexcept {
    parts.clear();
    until = -std::numeric_limits<double>::infinity();
  }
};

/// A ball about each object that moves, outside of which the tool does not touch it.
class NeighbourSearch {
 public:
  /// The tool is a point, or a ball where `tool_radius` [m] is above zero.
  NeighbourSearch(std::span<const Object> moving, double tool_radius);

  /// Object `i` is there now.
  void place(std::size_t i, const Pose& pose) noexcept;
  /// All have been placed: one more step in which they moved.
  void placed() noexcept;
  /// No list holds any more. What is not finite has been placed since, or may have been.
  void begin_anew() noexcept { drift_ = largest_ = 0.0; }

  std::size_t size() const { return balls_.size(); }
  /// [m] from the middle of an object's ball, squared: the tool at `position` does not touch it.
  bool is_outside(std::size_t i, const Vec3& position) const noexcept {
    return (position - balls_[i].center).squaredNorm() > balls_[i].square;
  }
  /// The point of the object's ball that is nearest to `position`.
  Vec3 nearest(std::size_t i, const Vec3& position) const noexcept {
    const Vec3 way = position - balls_[i].center;
    if (!(way.squaredNorm() > balls_[i].square)) return position;
    return balls_[i].center + std::sqrt(balls_[i].square / way.squaredNorm()) * way;
  }
  /// [m^2] of the ball's radius.
  double square(std::size_t i) const { return balls_[i].square; }
  /// Nearer to the ball than the margin that a list has.
  bool is_near(std::size_t i, const Vec3& position) const noexcept {
    return !((position - balls_[i].center).squaredNorm() > balls_[i].wide_square);
  }

  /// What is_near() said of all objects when the list was made still covers all that the tool at
  /// `position` could be in, and the straight way there.
  bool holds(const NeighbourList& near, const Vec3& position) const noexcept {
    const double left = near.until - drift_;
    return left > 0.0 && (position - near.from).squaredNorm() < left * left;
  }
  /// A list made now, of a tool at `position`.
  void mark(NeighbourList& near, const Vec3& position) const noexcept {
    near.from = position;
    near.until = drift_ + margin_;
  }

 private:
  struct Ball {
    Vec3 center = Vec3::Zero();  // [m]
    double square = 0.0;         // [m^2] of its radius
    double wide_square = 0.0;    // [m^2] of its radius and the margin
  };
  std::vector<Ball> balls_;    // side by side, for a tool passes by most of them
  std::vector<Vec3> middles_;  // [m, object frame]
  double margin_ = 0.0;        // [m]
  double drift_ = 0.0;         // [m] the fastest of each step, all steps together
  double largest_ = 0.0;       // [m^2] of this step's, squared
};

}  // namespace feltwire
