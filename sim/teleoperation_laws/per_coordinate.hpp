#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "sim/teleoperation_laws/spatial_law.hpp"

namespace feltwire::teleop {

/// A law of one degree of freedom on each coordinate by itself, without a coupling between them.
/// For the linear laws (P-P, P-F, 4-channel) and for wave variables with the impedance b I this is
/// the law in vectors. Source of the waves: Niemeyer, Slotine, "Stable adaptive teleoperation",
/// IEEE J. Oceanic Engineering 16(1), 1991, with b as a matrix.
/// Time-domain passivity has one observer and one controller for each coordinate. So no coordinate
/// may spend the energy of another. Decided here: one energy for all of them would let the damper
/// of one direction pay for the activity of another.
class PerCoordinate final : public SpatialLaw {
 public:
  using Make = std::function<std::unique_ptr<TeleoperationLaw>()>;
  explicit PerCoordinate(const Make& make) : laws_{make(), make(), make()} {}

  Vec3 lead(const SpatialLeaderSample& s, std::span<const SpatialDatagram> arrived,
            SpatialDatagram& out) override {
    Vec3 force;
    for (int i = 0; i < kAxes; ++i) {
      Datagram& sent = begin(out, i);
      force[i] = law(i).lead({s.time, s.position[i], s.velocity[i]}, of_axis(arrived, i), sent);
    }
    return force;
  }

  SpatialFollowerForce follow(const SpatialFollowerSample& s,
                              std::span<const SpatialDatagram> arrived,
                              SpatialDatagram& out) override {
    SpatialFollowerForce all;
    for (int i = 0; i < kAxes; ++i) {
      Datagram& sent = begin(out, i);
      const FollowerForce one = law(i).follow({s.time, s.position[i], s.velocity[i], s.force[i]},
                                              of_axis(arrived, i), sent);
      all.force[i] = one.force;
      all.reference[i] = one.reference;
      all.damping = one.damping;
    }
    return all;
  }

  Vec3 offset() const override {
    return {laws_[0]->offset(), laws_[1]->offset(), laws_[2]->offset()};
  }

 private:
  static constexpr int kAxes = 3;
  TeleoperationLaw& law(int axis) { return *laws_.at(static_cast<std::size_t>(axis)); }

  static Datagram& begin(SpatialDatagram& out, int axis) {
    Datagram& sent = out.axes.at(static_cast<std::size_t>(axis));
    sent.index = out.index;
    sent.time = out.time;
    return sent;
  }

  std::span<const Datagram> of_axis(std::span<const SpatialDatagram> arrived, int axis) {
    axis_.clear();
    for (const SpatialDatagram& d : arrived)
      axis_.push_back(d.axes.at(static_cast<std::size_t>(axis)));
    return axis_;
  }

  std::array<std::unique_ptr<TeleoperationLaw>, kAxes> laws_;
  std::vector<Datagram> axis_;  // that arrived for one coordinate
};

}  // namespace feltwire::teleop
