#pragma once
// Finds the bodies that take part in a simulation step that failed.

#include <mujoco/mujoco.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace feltwire {

/// Marks the trees of bodies (a tree: bodies that joints connect) that take part in a failure. A
/// tree is known by the number of its root body.
class DivergedTrees {
 public:
  explicit DivergedTrees(const mjModel& model)
      : model_(&model), marked_(static_cast<std::size_t>(model.nbody), 0) {
    ties_.reserve(kMostTies);
  }

  void clear() noexcept { std::ranges::fill(marked_, 0); }
  void mark_all() noexcept { std::ranges::fill(marked_, 1); }
  void mark(int body) noexcept { marked_[root(body)] = 1; }
  bool has(int body) const noexcept { return marked_[root(body)] != 0; }
  /// Stores which trees touch each other now. After a failure the bodies have moved apart, and it
  /// would be too late.
  void remember(const mjData& data) noexcept {
    ties_.clear();
    for (int i = 0; i < data.ncon && ties_.size() < kMostTies; ++i) {
      const int one = model_->geom_bodyid[data.contact[i].geom1];
      const int other = model_->geom_bodyid[data.contact[i].geom2];
      // A static body connects nothing.
      if (model_->body_weldid[one] == 0 || model_->body_weldid[other] == 0) continue;
      if (root(one) != root(other)) ties_.push_back({root(one), root(other)});
    }
  }
  /// Marks every tree that stored contacts connect to a marked one, directly or through others.
  void spread() noexcept {
    for (bool more = true; more;) {
      more = false;
      for (const auto& [one, other] : ties_) {
        if (marked_[one] == marked_[other]) continue;
        marked_[one] = marked_[other] = 1;
        more = true;
      }
    }
  }

 private:
  std::size_t root(int body) const noexcept {
    return static_cast<std::size_t>(model_->body_rootid[body]);
  }
  static constexpr std::size_t kMostTies = 4096;  // more would have to be allocated in a tick
  const mjModel* model_;
  std::vector<char> marked_;
  std::vector<std::pair<std::size_t, std::size_t>> ties_;
};

}  // namespace feltwire
