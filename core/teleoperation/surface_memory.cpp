#include "core/teleoperation/surface_memory.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

double height(const RemoteContact& surface, const Vec3& tip) noexcept {
  return (tip - surface.point).dot(surface.normal);
}
double away(const KnownSurface& surface, const Vec3& tip) noexcept {
  return length(Vec3(tip - surface.contact.point));
}

/// Returns true if the tool is behind the surface, but the measured force is too small.
bool missing(const RemoteContact& surface, const Vec3& tip, const Vec3& force) noexcept {
  constexpr double kHalf = 0.5;
  const double expected = -surface.stiffness * height(surface, tip);
  return expected > SurfaceMemory::kClear && force.dot(surface.normal) < kHalf * expected;
}

}  // namespace

void SurfaceMemory::keep(const KnownSurface& surface, const Vec3& tip) noexcept {
  if (count_ == kRemembered) {
    std::size_t farthest = 0;
    for (std::size_t i = 1; i < count_; ++i)
      if (away(known_[i], tip) > away(known_[farthest], tip)) farthest = i;
    forget(farthest);
  }
  KnownSurface& kept = known_[count_++];
  kept = surface;
  kept.contact.touching = false;
  kept.contact.velocity.setZero();
  kept.absent = 0.0;
  kept.told = true;  // Earlier reports have already given this surface as the contact.
}

std::optional<KnownSurface> SurfaceMemory::take(const Vec3& tip, const Vec3& direction,
                                                double reach) noexcept {
  constexpr double kSameWay = 0.7;  // cosine of 45 degrees
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < count_; ++i) {
    const RemoteContact& surface = known_[i].contact;
    if (direction.dot(surface.normal) < kSameWay) continue;
    const double off = std::abs(height(surface, tip));
    if (!(off <= reach)) continue;
    if (!nearest || off < std::abs(height(known_[*nearest].contact, tip))) nearest = i;
  }
  if (!nearest) return std::nullopt;
  const KnownSurface found = known_[*nearest];
  forget(*nearest);
  return found;
}

void SurfaceMemory::step(const Vec3& tip, const Vec3& force, double elapsed,
                         std::uint32_t& counted) noexcept {
  for (std::size_t i = count_; i-- > 0;) {
    KnownSurface& surface = known_[i];
    surface.absent = missing(surface.contact, tip, force) ? surface.absent + elapsed : 0.0;
    if (surface.absent >= kAbsent || !(away(surface, tip) < kNear)) forget(i);
  }
  // Sort the surfaces by ascending height into a short list of the nearest surfaces.
  std::array<std::size_t, OtherSurfaces::kMost> nearest{};
  std::size_t told = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double off = std::abs(height(known_[i].contact, tip));
    std::size_t at = told;
    while (at > 0 && off < std::abs(height(known_[nearest[at - 1]].contact, tip))) --at;
    if (at == nearest.size()) continue;
    told = std::min(told + 1, nearest.size());
    for (std::size_t n = told - 1; n > at; --n) nearest[n] = nearest[n - 1];
    nearest[at] = i;
  }
  told_ = {};
  std::array<bool, kRemembered> is_told{};
  for (std::size_t n = 0; n < told; ++n) {
    KnownSurface& surface = known_[nearest[n]];
    if (!surface.told) surface.contact.surface = ++counted;
    is_told[nearest[n]] = true;
    told_.surfaces[n] = surface.contact;
    told_.count = static_cast<int>(n) + 1;
  }
  for (std::size_t i = 0; i < count_; ++i) known_[i].told = is_told[i];
}

}  // namespace feltwire
