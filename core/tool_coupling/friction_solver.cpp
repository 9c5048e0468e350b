#include "core/tool_coupling/friction_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

constexpr int kSweeps = 4;      // number of sweeps over the patches
constexpr int kRootSteps = 12;  // largest number of root-finding steps per patch
constexpr double kCloseToCone = 1e-3;
constexpr std::uint64_t kSolveWork = 16;  // units of work per system of six equations

double limit_of(const FrictionPatch& patch, bool slipping) {
  return (slipping ? patch.dynamic_friction : patch.static_friction) * patch.load;
}

double slip_of(const FrictionPatch& patch, const Vec6& motion) {
  const Vec6 against = motion - patch.carried;
  return std::sqrt(std::max(0.0, against.dot(patch.slip * against)));
}

/// Treats each patch as a spring with the stiffness (friction limit) / slip. At the minimum of the
/// total energy, the spring forces equal the friction forces.
struct Springs {
  const Mat6& stiffness;
  const Vec6& wrench;
  std::span<const FrictionPatch> patches;
  WorkLimit* work;
  std::array<double, ShellContact::kFrictionPatches> of{};  // [N/m] spring stiffness of each patch
  Vec6 motion = Vec6::Zero();

  void solve() {
    if (!may_go_on(work, kSolveWork)) return;
    Mat6 all = stiffness;
    Vec6 pull = wrench;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      if (of[i] == 0.0) continue;
      all += of[i] * patches[i].slip;
      pull += of[i] * (patches[i].slip * patches[i].carried);
    }
    motion = all.ldlt().solve(pull);
  }

  /// Returns limit / slip - `spring` for a patch with the stiffness `spring`. Near its root, this
  /// function of the stiffness is almost linear.
  double excess(std::size_t i, double limit, double spring) {
    of[i] = spring;
    solve();
    return limit / std::max(slip_of(patches[i], motion), kHeld * kHeld) - spring;
  }

  /// Finds the spring stiffness of one patch and leaves the others unchanged.
  void find(std::size_t i, double limit) {
    double high = limit / kHeld, above = excess(i, limit, high);
    if (above >= 0.0 || limit == 0.0) return;  // The patch does not slip.
    double low = 0.0, below = excess(i, limit, low);
    int last = 0;
    for (int n = 0; n < kRootSteps; ++n) {  // This is regula falsi with the Illinois rule.
      const double between = (low * above - high * below) / (above - below);
      const double value = excess(i, limit, between);
      if (std::abs(value) <= kCloseToCone * between) return;
      if (value > 0.0) {
        low = between;
        below = value;
        if (last > 0) above *= 0.5;
        last = 1;
      } else {
        high = between;
        above = value;
        if (last < 0) below *= 0.5;
        last = -1;
      }
    }
  }

  bool all_on_their_cones(bool slipping) const {
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const double limit = limit_of(patches[i], slipping);
      const double force = of[i] * slip_of(patches[i], motion);
      const bool holds = of[i] >= limit / kHeld && force <= limit;
      if (!holds && std::abs(force - limit) > kCloseToCone * limit) return false;
    }
    return true;
  }
};

}  // namespace

FrictionSolution solve_friction(const Mat6& stiffness, const Vec6& wrench,
                                std::span<const FrictionPatch> patches, bool slipping,
                                WorkLimit* work) noexcept {
  Springs springs{stiffness, wrench, patches, work};
  if (patches.empty()) springs.solve();
  for (int sweep = 0; sweep < kSweeps && !is_cut(work); ++sweep) {
    for (std::size_t i = 0; i < patches.size(); ++i)
      springs.find(i, limit_of(patches[i], slipping));
    if (patches.size() < 2 || springs.all_on_their_cones(slipping)) break;
  }
  FrictionSolution result;
  result.motion = springs.motion;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    result.friction[i] = springs.of[i] * (patches[i].slip * (patches[i].carried - springs.motion));
    result.slips |= slip_of(patches[i], springs.motion) > kHeld;
  }
  return result;
}

double friction_work(std::span<const FrictionPatch> patches, bool slipping,
                     const Vec6& motion) noexcept {
  double work = 0.0;
  for (const FrictionPatch& patch : patches)
    work += limit_of(patch, slipping) * slip_of(patch, motion);
  return work;
}

}  // namespace feltwire
