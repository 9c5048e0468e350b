#pragma once
// Which bodies have to do with a step that came to nothing.

#include <mujoco/mujoco.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace feltwire {

/// Which trees of bodies, joined together, have to do with something that broke. By the number of
/// their root.
class BrokenTrees {
 public:
  BrokenTrees() = default;
  explicit BrokenTrees(const mjModel& model)
      : model_(&model), marked_(static_cast<std::size_t>(model.nbody), 0) {
    ties_.reserve(kMostTies);
  }

  void clear() noexcept { std::ranges::fill(marked_, 0); }
  void mark_all() noexcept { std::ranges::fill(marked_, 1); }
  void mark(int body) noexcept { marked_[root(body)] = 1; }
  bool has(int body) const noexcept { return marked_[root(body)] != 0; }
  /// Keeps which bodies touch each other now: when something has broken they are apart already.
  void remember(const mjData& data) noexcept {
    ties_.clear();
    for (int i = 0; i < data.ncon && ties_.size() < kMostTies; ++i) {
      const int one = model_->geom_bodyid[data.contact[i].geom1];
      const int other = model_->geom_bodyid[data.contact[i].geom2];
      // What stands ties nothing together.
      if (model_->body_weldid[one] == 0 || model_->body_weldid[other] == 0) continue;
      if (root(one) != root(other)) ties_.push_back({root(one), root(other)});
    }
  }
  /// To everything that contacts tied together with what is marked.
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
  static constexpr std::size_t kMostTies = 4096;  // beyond them a tick would have to allocate
  const mjModel* model_ = nullptr;
  std::vector<char> marked_;
  std::vector<std::pair<std::size_t, std::size_t>> ties_;
};

}  // namespace feltwire
