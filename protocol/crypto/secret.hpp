#pragma once
// Secrets, which must not be left behind in memory or in a core dump.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// A secret text: every copy is wiped when it is destroyed.
class Secret {
 public:
  Secret() = default;
  explicit Secret(std::string_view text) : bytes_(text.begin(), text.end()) {}
  Secret(const Secret&) = default;
  Secret(Secret&&) noexcept = default;
  Secret& operator=(Secret other) noexcept {
    bytes_.swap(other.bytes_);
    return *this;
  }
  ~Secret();

  std::string_view text() const { return {bytes_.data(), bytes_.size()}; }
  bool empty() const { return bytes_.empty(); }

 private:
  // Not a std::string: a short one lies in the object itself, and a move leaves a copy behind.
  std::vector<char> bytes_;
};

void wipe(std::string& text) noexcept;
void wipe(std::vector<std::uint8_t>& bytes) noexcept;

/// Keys and tokens are in this process's memory: from now on the system writes no core of it, and
/// no other process of the same user may look into it (PR_SET_DUMPABLE).
void forbid_core_dumps() noexcept;

/// From now on a system that gives libsodium no random numbers ends the program with a message and
/// exit status 1, where libsodium would have it abort.
void end_without_random_numbers() noexcept;

}  // namespace feltwire
