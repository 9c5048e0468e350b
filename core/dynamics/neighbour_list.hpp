#pragma once
// A list of the moving objects near a tool. It is valid until the tool and the objects may have
// approached each other by its margin (Verlet 1967, "Computer 'experiments' on classical fluids").
// So a scene of thousands of objects costs as much as the few near the tool.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"

namespace feltwire {

/// The list of one tool. Before the first search it is empty and not valid at any place.
struct NeighbourList {
  std::vector<std::uint32_t> parts;  // moving objects, rising
  Vec3 from = Vec3::Zero();          // [m] where the tool was when the list was made
  /// [m] The list ends when the movement of the objects (the fastest of each step) reaches this.
  double until = -std::numeric_limits<double>::infinity();

  bool known() const { return until > -std::numeric_limits<double>::infinity(); }
  void forget() noexcept {
    parts.clear();
    until = -std::numeric_limits<double>::infinity();
  }
};

/// A ball about each moving object. Outside of it the tool does not touch the object.
class NeighbourSearch {
 public:
  /// The tool is a point, or a ball where `tool_radius` [m] is above zero.
  NeighbourSearch(std::span<const Object> moving, double tool_radius);

  /// Object `i` is at `pose` now.
  void place(std::size_t i, const Pose& pose) noexcept;
  /// Ends a step: every object has been placed.
  void placed() noexcept;
  /// Counts the movement of the objects from zero again, after a pose that may not have been
  /// finite. The caller must discard every list.
  void begin_anew() noexcept { drift_ = largest_ = 0.0; }

  std::size_t size() const { return balls_.size(); }
  /// Whether a tool at `position` [m, world] is outside the ball of object `i`: it does not touch
  /// the object.
  bool is_outside(std::size_t i, const Vec3& position) const noexcept {
    return (position - balls_[i].center).squaredNorm() > balls_[i].square;
  }
  /// The point of the object's ball that is nearest to `position`.
  Vec3 nearest(std::size_t i, const Vec3& position) const noexcept {
    const Vec3 way = position - balls_[i].center;
    if (!(way.squaredNorm() > balls_[i].square)) return position;
    return balls_[i].center + std::sqrt(balls_[i].square / way.squaredNorm()) * way;
  }
  /// [m^2] The square of the ball's radius.
  double square(std::size_t i) const { return balls_[i].square; }
  /// Whether `position` is in the ball of object `i`, or nearer to it than the margin of a list.
  bool is_near(std::size_t i, const Vec3& position) const noexcept {
    return !((position - balls_[i].center).squaredNorm() > balls_[i].wide_square);
  }

  /// Whether the list still has every object that a tool at `position`, or on the straight path
  /// there, could touch.
  bool holds(const NeighbourList& near, const Vec3& position) const noexcept {
    const double left = near.until - drift_;
    return left > 0.0 && (position - near.from).squaredNorm() < left * left;
  }
  /// Marks a list as made now, for a tool at `position`.
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
  std::vector<Ball> balls_;    // adjacent in memory, because every tool tests all of them
  std::vector<Vec3> middles_;  // [m, object frame]
  double margin_ = 0.0;        // [m]
  double drift_ = 0.0;         // [m] summed movement of the fastest object of each step
  double largest_ = 0.0;       // [m^2] the square of this step's largest way so far
};

}  // namespace feltwire
