#pragma once
// Secrets, which must not stay in memory or in a core dump.

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
  // Not a std::string: a short one is stored in the object itself, and a move leaves a copy behind.
  std::vector<char> bytes_;
};

void wipe(std::string& text) noexcept;
void wipe(std::vector<std::uint8_t>& bytes) noexcept;

/// This process's memory contains keys and tokens. From now on the system writes no core dump of
/// it, and no other process of the same user may read it (PR_SET_DUMPABLE).
void forbid_core_dumps() noexcept;

/// From now on, if the system gives libsodium no random numbers, the program ends with a message
/// and exit status 1; libsodium alone would abort.
void end_without_random_numbers() noexcept;

}  // namespace feltwire
