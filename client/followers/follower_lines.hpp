#pragma once
// The lines that a driver and feltwire exchange (docs/followers.md). Plain text, one message a
// line: a word, a number, and fields NAME=VALUE with single blanks between them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/teleoperation/follower.hpp"

namespace feltwire::follower_lines {

inline constexpr int kVersion = 1;
inline constexpr std::size_t kLongestLine = 1024;  // [bytes] with the line's end

/// An error in a line: the field, or the first word, and the remedy. `field` lives as long as the
/// line; `what` lives as long as the program.
struct Fault {
  std::string_view field;
  std::string_view what;
};

/// "follower 1 name=NAME period=S ...", a driver's first line. Fills `spec`.
std::optional<Fault> read_hello(std::string_view line, FollowerSpec& spec);

/// Reads "state N pose=X,Y,Z,QW,QX,QY,QZ ...". Fills `number` and `reading`, or leaves both
/// unchanged after a fault. It does not allocate or throw.
std::optional<Fault> read_state(std::string_view line, std::uint64_t& number,
                                FollowerReading& reading) noexcept;

/// Writes "target N pose=... gripper=...\n" into `line`; returns its length, 0 if it does not fit.
/// It does not allocate or throw.
std::size_t write_target(std::uint64_t number, const FollowerTarget& target,
                         std::span<char> line) noexcept;

/// Assembles bytes into lines, in a buffer of fixed size.
class Lines {
 public:
  /// The place for the next bytes. Never empty.
  std::span<char> room() noexcept;
  /// Reports how many bytes were written there.
  void added(std::size_t count) noexcept { filled_ += count; }

  struct Line {
    std::uint64_t number = 0;  // from 1
    std::string_view text;     // without its end; until the next call of room()
    bool too_long = false;     // the text is only the beginning
  };
  /// Returns the next whole line; empty ones are skipped.
  std::optional<Line> next() noexcept;

 private:
  std::array<char, 4 * kLongestLine> bytes_{};
  std::size_t begin_ = 0, filled_ = 0;
  std::uint64_t count_ = 0;
  bool skipping_ = false;  // skips the rest of a line that was too long
};

}  // namespace feltwire::follower_lines
