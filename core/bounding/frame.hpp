#pragma once
// A force in the channels of a contact: along its normal, and across it.

#include <limits>

#include "core/bounding/step.hpp"
#include "core/numeric.hpp"

namespace feltwire {

/// A command as e u + friction, friction orthogonal to u.
template <class Real>
struct ChannelCommand {
  Vector3<Real> normal;      // u = elastic / |elastic|; zero without an elastic force
  Real spring;               // [N] |elastic|
  Real elastic;              // [N] along u, with what friction (contact damping) has along it
  Vector3<Real> frictional;  // [N]
};

template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command) noexcept {
  const Polar<Real> elastic = polar(command.elastic);
  const Real along_normal = command.frictional.dot(elastic.direction);
  ChannelCommand<Real> c{elastic.direction, elastic.length, elastic.length + along_normal,
                         command.frictional - along_normal * elastic.direction};
  // What the subtraction leaves by rounding is no friction; bounded, it could take the elastic
  // force with it.
  constexpr Real kRounding = 64 * std::numeric_limits<Real>::epsilon();
  if (c.frictional.squaredNorm() <= kRounding * kRounding * command.frictional.squaredNorm())
    c.frictional.setZero();
  return c;
}

/// A force that is held, in the frame it was commanded in.
template <class Real>
struct HeldForce {
  Vector3<Real> normal = Vector3<Real>::Zero();      // u_p; free while no elastic force is held
  Real elastic = 0;                                  // [N] along it, >= 0
  Vector3<Real> frictional = Vector3<Real>::Zero();  // [N]

  /// The channels are found anew: whatever reports a held force may have bent it.
  void set(const BasicCommand<Real>& held) noexcept {
    const ChannelCommand<Real> c = in_channels(held);
    set(c.normal, c.elastic, c.frictional);
  }
  /// A negative `along_normal`, a pull, is an elastic channel opposite to its normal.
  void set(const Vector3<Real>& unit, Real along_normal, const Vector3<Real>& across) noexcept {
    elastic = std::abs(along_normal);
    normal = along_normal < 0 ? Vector3<Real>(-unit) : unit;
    frictional = across;
  }
  Real magnitude() const noexcept { return hypotenuse(elastic, length(frictional)); }
};

/// What was held and how the device moved, in the frame u_p that was held. When no elastic force
/// was held the frame is free: the new one is taken, and the held force is split in it. |F|^2 is
/// the sum of both parts' squares in every frame, so no storage is made or lost.
template <class Real>
struct HeldFrame {
  Real elastic;              // [N]
  Vector3<Real> frictional;  // [N]
  Real dx_elastic;           // [m] along u_p
  Vector3<Real> dx_frictional;
  bool reframed;

  HeldFrame(const HeldForce<Real>& held, const Vector3<Real>& new_normal,
            const Vector3<Real>& displacement) noexcept
      : reframed(!(held.elastic > 0)) {
    const Vector3<Real>& u = reframed ? new_normal : held.normal;
    elastic = reframed ? held.frictional.dot(u) : held.elastic;
    frictional = reframed ? Vector3<Real>(held.frictional - elastic * u) : held.frictional;
    dx_elastic = displacement.dot(u);
    dx_frictional = displacement - dx_elastic * u;
  }
};

/// The factor that brings `wanted` under `allowed`.
template <class Real>
inline Real reduction(Real allowed, Real wanted) noexcept {
  return wanted > allowed ? allowed / wanted : Real(1);
}

}  // namespace feltwire
