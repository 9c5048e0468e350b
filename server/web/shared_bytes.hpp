#pragma once
// Bytes on their way to other programs: those of one connection, and those that several share.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace feltwire::web {

/// Bytes that are stored once, however many connections have to write them.
class SharedBytes {
 public:
  SharedBytes() = default;
  explicit SharedBytes(std::vector<std::uint8_t> bytes) : SharedBytes(keep(std::move(bytes))) {}
  explicit SharedBytes(std::string text) : SharedBytes(keep(std::move(text))) {}
  /// Bytes that live as long as the program.
  static SharedBytes of_program(std::span<const std::uint8_t> bytes) {
    SharedBytes shared;
    shared.bytes_ = bytes;
    return shared;
  }

  std::span<const std::uint8_t> bytes() const { return bytes_; }
  std::string_view text() const {
    return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()};
  }
  std::size_t size() const { return bytes_.size(); }
  bool empty() const { return bytes_.empty(); }

 private:
  template <class Kept>
  static std::shared_ptr<const Kept> keep(Kept kept) {
    return std::make_shared<const Kept>(std::move(kept));
  }
  template <class Kept>
  explicit SharedBytes(std::shared_ptr<const Kept> kept)
      : bytes_(reinterpret_cast<const std::uint8_t*>(kept->data()), kept->size()),
        owner_(std::move(kept)) {}

  std::span<const std::uint8_t> bytes_;
  std::shared_ptr<const void> owner_;  // null: the program has them
};

/// The next bytes that a connection writes: its own, then shared ones.
struct Output {
  std::vector<std::uint8_t> own;
  SharedBytes shared;
  bool empty() const { return own.empty() && shared.empty(); }
};

}  // namespace feltwire::web
