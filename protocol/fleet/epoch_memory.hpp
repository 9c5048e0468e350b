#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "protocol/fleet/epoch.hpp"

namespace feltwire {

/// The highest epoch that a process has seen of each scene. Hosts, clients and gateways keep one
/// and refuse a lower epoch, wherever it comes from: a directory may forget what it has
/// acknowledged. It grows with the number of scenes; the caller admits only scenes that it knows.
class EpochMemory {
 public:
  /// Remembers the epoch. Returns false if a higher one was seen of this scene, or if it is not
  /// possible: refuse it.
  [[nodiscard]] bool admit(std::string_view scene, const Epoch& offered) {
    const auto known = highest_.find(scene);
    if (known != highest_.end()) return feltwire::admit(known->second, offered);
    Epoch none;
    if (!feltwire::admit(none, offered)) return false;
    highest_.emplace(scene, offered);
    return true;
  }

  /// {0, 0} for a scene that was never seen.
  Epoch highest(std::string_view scene) const {
    const auto known = highest_.find(scene);
    return known != highest_.end() ? known->second : Epoch{};
  }

  std::size_t scenes() const noexcept { return highest_.size(); }

 private:
  std::map<std::string, Epoch, std::less<>> highest_;
};

}  // namespace feltwire
