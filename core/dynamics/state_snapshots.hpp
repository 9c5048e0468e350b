#pragma once
// Earlier good states of a simulation, to which it returns after a bad step.

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace feltwire {

/// The places of the bodies of a MuJoCo simulation, without velocities.
struct StateSnapshot {
  std::vector<mjtNum> coordinates, activations;
  std::uint64_t step = 0;

  /// Returns the simulation to this state, at rest.
  void restore(const mjModel& model, mjData& data) const noexcept {
    mj_resetData(&model, &data);
    std::copy(coordinates.begin(), coordinates.end(), data.qpos);
    std::copy(activations.begin(), activations.end(), data.act);
  }
};

/// The first state, and a ring of the newest good ones. Only the constructor allocates.
class StateSnapshots {
 public:
  /// The present state is the first one, at step 0.
  StateSnapshots(const mjModel& model, const mjData& data)
      : initial_{{data.qpos, data.qpos + model.nq}, {data.act, data.act + model.na}, 0},
        ring_(kMost, initial_) {}

  const StateSnapshot& initial() const { return initial_; }
  void keep(const mjModel& model, const mjData& data, std::uint64_t step) noexcept {
    newest_ = (newest_ + 1) % kMost;
    kept_ = std::min(kept_ + 1, kMost);
    StateSnapshot& place = ring_[newest_];
    std::copy_n(data.qpos, model.nq, place.coordinates.begin());
    std::copy_n(data.act, model.na, place.activations.begin());
    place.step = step;
  }
  /// Removes all states younger than `step`, and the next one. Returns that one.
  const StateSnapshot& take_before(std::uint64_t step) noexcept {
    while (kept_ > 0) {
      const StateSnapshot& last = ring_[newest_];
      newest_ = (newest_ + kMost - 1) % kMost;
      --kept_;
      if (last.step <= step) return last;
    }
    return initial_;
  }

 private:
  static constexpr std::size_t kMost = 16;
  StateSnapshot initial_;
  std::vector<StateSnapshot> ring_;
  std::size_t newest_ = 0, kept_ = 0;
};

}  // namespace feltwire
