#pragma once
// A force in the channels of a contact: along its normal, and across it.

#include <limits>

#include "core/base/numeric.hpp"
#include "core/bounding/metric.hpp"
#include "core/bounding/step.hpp"

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
  // The rest that rounding leaves is no friction. If it were bounded, it could take the elastic
  // force with it.
  constexpr Real kRounding = 64 * std::numeric_limits<Real>::epsilon();
  if (c.frictional.squaredNorm() <= kRounding * kRounding * command.frictional.squaredNorm())
    c.frictional.setZero();
  return c;
}

/// The channels of a contact, in the coordinates of `metric`: a contact never pulls, and without an
/// elastic force there is no normal, so that friction has the whole movement under any damping.
template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command,
                                        const Metric<Real>& metric) noexcept {
  ChannelCommand<Real> c = in_channels(command);
  c.elastic = std::max(Real(0), c.elastic);
  if (!(c.elastic > 0)) c.normal.setZero();
  if (metric.euclidean()) return c;
  // In these coordinates friction may well have a part along u, and more of it than the spring:
  // what is across the normal for the eye is not what the device damps apart.
  const Real spring_share = c.elastic > 0 ? c.spring / c.elastic : Real(0);
  c = in_channels(BasicCommand<Real>{metric.force(c.elastic * c.normal), metric.force(c.frictional),
                                     Vector3<Real>::Zero()});
  c.spring *= spring_share;
  return c;
}

/// The factors that a bound applies to a command's channels.
template <class Real>
struct ChannelScales {
  Real elastic, frictional;
};

/// The bounded force, in the world frame again.
template <class Real>
inline BasicCommand<Real> held_back(const ChannelCommand<Real>& command,
                                    const ChannelScales<Real>& scale,
                                    const Metric<Real>& metric) noexcept {
  return {metric.force_back((scale.elastic * command.elastic) * command.normal),
          metric.force_back(scale.frictional * command.frictional), Vector3<Real>::Zero()};
}

/// A force that is held, in the frame it was commanded in.
template <class Real>
struct HeldForce {
  Vector3<Real> normal = Vector3<Real>::Zero();      // u_p; free while no elastic force is held
  Real elastic = 0;                                  // [N] along it, >= 0
  Vector3<Real> frictional = Vector3<Real>::Zero();  // [N]

  /// The channels are found anew: whatever reports a held force may have bent it.
  void set(const BasicCommand<Real>& held, const Metric<Real>& metric) noexcept {
    const ChannelCommand<Real> c = in_channels(
        BasicCommand<Real>{metric.force(held.elastic), metric.force(held.frictional), held.torque});
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

/// The held force and the movement of the device, in the frame u_p of the held force. When no
/// elastic force was held the frame is free: the new one is taken, and the held force is split in
/// it. |F|^2 is the sum of both parts' squares in every frame, so no storage is made or lost.
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
