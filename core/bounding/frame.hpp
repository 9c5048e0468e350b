#pragma once
// Splits a force into the channels of a contact: along the normal and across it.

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
  Real elastic;              // [N] along u, with the part of friction (contact damping) along u
  Vector3<Real> frictional;  // [N]
};

/// `elastic` is polar(command.elastic).
template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command,
                                        const Polar<Real>& elastic) noexcept {
  const Real along_normal = command.frictional.dot(elastic.direction);
  ChannelCommand<Real> c{elastic.direction, elastic.length, elastic.length + along_normal,
                         command.frictional - along_normal * elastic.direction};
  // A remainder from rounding is not friction. Bounded as friction, it could reduce the elastic
  // force, too.
  constexpr Real kRounding = 64 * std::numeric_limits<Real>::epsilon();
  if (c.frictional.squaredNorm() <= kRounding * kRounding * command.frictional.squaredNorm())
    c.frictional.setZero();
  return c;
}

template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command) noexcept {
  return in_channels(command, polar(command.elastic));
}

/// The channels of a contact, in the coordinates of `metric`. A contact never pulls. Without an
/// elastic force there is no normal, and the whole movement belongs to friction.
template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command,
                                        const Polar<Real>& elastic,
                                        const Metric<Real>& metric) noexcept {
  ChannelCommand<Real> c = in_channels(command, elastic);
  c.elastic = std::max(Real(0), c.elastic);
  if (!(c.elastic > 0)) c.normal.setZero();
  if (metric.euclidean()) return c;
  // In these coordinates friction may have a part along u, even larger than the spring: two
  // orthogonal directions in space are not orthogonal in the metric of the damping.
  const Real spring_share = c.elastic > 0 ? c.spring / c.elastic : Real(0);
  const Vector3<Real> along = metric.force(c.elastic * c.normal);
  c = in_channels(BasicCommand<Real>{along, metric.force(c.frictional), Vector3<Real>::Zero()},
                  polar(along));
  c.spring *= spring_share;
  return c;
}
template <class Real>
inline ChannelCommand<Real> in_channels(const BasicCommand<Real>& command,
                                        const Metric<Real>& metric) noexcept {
  return in_channels(command, polar(command.elastic), metric);
}

/// The factors by which a bound scales a command's channels.
template <class Real>
struct ChannelScales {
  Real elastic, frictional;
};

/// The bounded force, back in the world frame.
template <class Real>
inline BasicCommand<Real> held_back(const ChannelCommand<Real>& command,
                                    const ChannelScales<Real>& scale,
                                    const Metric<Real>& metric) noexcept {
  return {metric.force_back((scale.elastic * command.elastic) * command.normal),
          metric.force_back(scale.frictional * command.frictional), Vector3<Real>::Zero()};
}

/// A held force, in the frame in which it was commanded.
template <class Real>
struct HeldForce {
  Vector3<Real> normal = Vector3<Real>::Zero();      // u_p; free while no elastic force is held
  Real elastic = 0;                                  // [N] along it, >= 0
  Vector3<Real> frictional = Vector3<Real>::Zero();  // [N]

  /// Splits the force again, because a report of a held force may have another direction.
  void set(const BasicCommand<Real>& held, const Metric<Real>& metric) noexcept {
    const Vector3<Real> along = metric.force(held.elastic);
    const ChannelCommand<Real> c = in_channels(
        BasicCommand<Real>{along, metric.force(held.frictional), held.torque}, polar(along));
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

/// The held force and the movement of the device, in the frame u_p of the held force. If no elastic
/// force was held, the frame is free: then the new command's frame is used, and the held force is
/// split in it. |F|^2 is the sum of the squares of both parts in every frame, so this neither makes
/// nor loses storage.
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

/// The factor, at most 1, that reduces `wanted` to `allowed`.
template <class Real>
inline Real reduction(Real allowed, Real wanted) noexcept {
  return wanted > allowed ? allowed / wanted : Real(1);
}
/// The reduction for the lengths of two vectors. It computes no root if nothing is to be reduced.
template <class Real>
inline Real reduction(const Vector3<Real>& allowed, const Vector3<Real>& wanted) noexcept {
  if (wanted.isZero(0)) return Real(1);
  const Real squared = wanted.squaredNorm(), most = allowed.squaredNorm();
  if (is_plain_square(squared) && is_plain_square(most)) [[likely]]
    return squared > most ? std::sqrt(most / squared) : Real(1);
  return reduction(length(allowed), length(wanted));
}

}  // namespace feltwire
