#pragma once
// A robot whose driver is another program, in any language: lines of text over a Unix socket
// (docs/followers.md).

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "client/followers/follower_lines.hpp"
#include "client/followers/reported_robot.hpp"
#include "core/teleoperation/follower.hpp"

namespace feltwire {

/// An open file descriptor, closed at the end.
class OwnDescriptor {
 public:
  explicit OwnDescriptor(int descriptor) : descriptor_(descriptor) {}
  OwnDescriptor(OwnDescriptor&& other) noexcept : descriptor_(other.descriptor_) {
    other.descriptor_ = -1;
  }
  OwnDescriptor(const OwnDescriptor&) = delete;
  OwnDescriptor& operator=(const OwnDescriptor&) = delete;
  OwnDescriptor& operator=(OwnDescriptor&&) = delete;
  ~OwnDescriptor();
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// The driver's states are the readings; the targets go to the driver, by the rules of
/// ReportedRobot. A driver that closes the connection is not ok. A line with a fault is not used:
/// the driver gets its number, the field and the remedy. If a driver does not read in time, targets
/// are dropped; at most some ten wait in the socket.
class SocketFollower final : public Follower {
 public:
  /// A driver that writes without end must not keep the servo: one read() takes so many lines with
  /// a fault, and answers so many of them. The rest waits in the socket.
  static constexpr int kMostFaults = 64, kMostAnswers = 4;

  /// `socket` is connected, and its driver has sent `spec`; `rest` are the lines after that.
  SocketFollower(OwnDescriptor socket, FollowerSpec spec, const follower_lines::Lines& rest);

  const FollowerSpec& spec() const override { return spec_; }
  FollowerReading read(Nanoseconds now) noexcept override;
  /// Before the first state nothing is sent.
  FollowerTarget write(const FollowerTarget& target) noexcept override;
  void hold() noexcept override;

  /// Lines that could not be used so far.
  std::uint64_t faults() const noexcept { return faults_; }

 private:
  void receive(Nanoseconds now) noexcept;
  /// Returns whether the line had no fault; otherwise the driver hears of it, if `answers`.
  bool take(const follower_lines::Lines::Line& line, Nanoseconds now, bool answers) noexcept;
  bool send(const char* text, std::size_t size) noexcept;
  bool flush() noexcept;

  OwnDescriptor socket_;
  FollowerSpec spec_;
  follower_lines::Lines lines_;
  ReportedRobot robot_;
  std::uint64_t newest_ = 0;  // number of the driver's newest state
  bool connected_ = true;
  std::uint64_t sent_ = 0, faults_ = 0;
  std::array<char, follower_lines::kLongestLine>
      pending_{};  // the rest of a line that is partly sent
  std::size_t pending_size_ = 0;
  std::atomic<bool> hold_{false};
  bool hold_said_ = false;
};

/// Waits for a driver at a path.
class FollowerListener {
 public:
  /// [bytes] without a hello, after which a driver is refused.
  static constexpr std::size_t kMostBeforeHello = 65536;

  /// Creates the socket, which only this user may open; it replaces one of an earlier run. Throws
  /// std::runtime_error that names the path and the remedy.
  explicit FollowerListener(std::filesystem::path path);
  ~FollowerListener();
  FollowerListener(const FollowerListener&) = delete;
  FollowerListener& operator=(const FollowerListener&) = delete;

  /// Waits for the first driver that sends its first line. Throws std::runtime_error if there is
  /// none in time, or in kMostBeforeHello, or if the line has a fault; the driver gets the error of
  /// the line, too.
  std::unique_ptr<SocketFollower> wait(Nanoseconds longest);

 private:
  std::filesystem::path path_;
  OwnDescriptor socket_;
};

}  // namespace feltwire
