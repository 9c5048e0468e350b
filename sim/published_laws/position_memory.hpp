#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/published_laws/contact_force.hpp"

namespace feltwire {

/// Memory-based passivation: in the graph of force over position, the way out is kept below the way
/// in. While the hand presses, the force is written to a memory at each position; while it
/// releases, the force is at most the stored one.
/// Source: J.-H. Ryu, M.-Y. Yoon, "Memory-based passivation approach for stable haptic
/// interaction", IEEE/ASME Trans. Mechatronics 19(4), 2014.
/// Taken: the memory addressed by position, written on the way in, an upper bound on the way out.
/// Left open there, or not available, decided here:
///  - A position is a cell of one encoder quantum of the depth, which is the sum of the movements
///    along the mean of both samples' normals since the contact began: round a ball it does not
///    drift. The source's extension to more degrees of freedom by a proxy is not used.
///  - On the way in every passed cell gets the force that was held there, F(n-1). On the way out
///    the force is at most that of the cells that the hand leaves in the next sample at its
///    present speed, and of one at least.
///  - In the sample in which the hand turns, the force of the way in is still held.
///  - Beyond the last cell all depths are one.
class PositionMemory {
 public:
  explicit PositionMemory(double quantum) : quantum_(quantum > 0.0 ? quantum : kNoEncoder) {}

  Command step(const BoundingStep& s) noexcept {
    const ContactForce contact(s);
    if (!(contact.wanted > 0.0)) {
      *this = PositionMemory(quantum_);
      return {};
    }
    if (normal_.isZero(0)) normal_ = contact.normal;
    const int before = cell(depth_);
    depth_ -= s.displacement.dot(0.5 * (contact.normal + normal_));
    normal_ = contact.normal;
    const int now = cell(depth_);
    for (int i = before; i < now; ++i) memory_[index(i)] = static_cast<float>(held_);
    if (now != before) releasing_ = now < before;
    held_ = contact.wanted;
    if (releasing_) {
      const int last = now - std::max(1, before - now);
      for (int i = now - 1; i >= last; --i)
        held_ = std::min(held_, static_cast<double>(memory_[index(i)]));
    }
    return contact.rendered(held_);
  }
  void set_held(const Command& held) noexcept {
    held_ = std::min(held_, held.force().dot(direction(held.elastic)));
  }

 private:
  static constexpr double kNoEncoder = 1e-5;  // [m]
  static constexpr int kCells = 224;

  int cell(double depth) const noexcept {
    return static_cast<int>(std::lround(std::clamp(depth / quantum_, -1e6, 1e6)));
  }
  static std::size_t index(int cell) noexcept {
    return static_cast<std::size_t>(std::clamp(cell, 0, kCells - 1));
  }

  double quantum_;                      // [m] of a cell
  Vec3 normal_ = Vec3::Zero();          // of the sample before
  double depth_ = 0.0, held_ = 0.0;     // [m] since contact; F(n-1) [N]
  bool releasing_ = false;              // the last movement led out
  std::array<float, kCells> memory_{};  // [N] by cell
};

}  // namespace feltwire
