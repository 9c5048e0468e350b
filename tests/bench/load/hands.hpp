#pragma once
// Hands that send real samples and take real replies, many in one thread. Each has its own session
// and its own UDP port. No servo runs: a hand moves on its path, whatever force it gets.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/transport/control_client.hpp"
#include "client/transport/transport.hpp"
#include "core/base/histogram.hpp"

namespace feltwire::load {

struct Options {
  ServerAccess server;
  std::string scene;
  SessionParameters parameters;
  double depth = 0.005;    // [m] to which the hands press, at the start of the scene
  std::uint64_t seed = 1;  // of the hands' phases
};

/// The counts of a time.
struct Counts {
  std::uint64_t datagrams = 0, replies = 0, with_force = 0;
  std::uint64_t skipped = 0;  // turns of 1 ms that this program came too late for
  Histogram round_trip;       // [ns] from the sample's time to the time when the reply was found
};

/// For one thread.
class Hands {
 public:
  explicit Hands(const Options& options);
  ~Hands();
  Hands(const Hands&) = delete;
  Hands& operator=(const Hands&) = delete;

  /// Joins one more hand. Blocks during the join. Throws SessionError.
  void join_one();
  /// Moves all hands until then. A turn takes one period of the servo, and the hands have their
  /// places in it, because real hands do not send at the same time.
  void run_until(Nanoseconds end);
  /// The counts since the last call.
  Counts take_counts();
  std::size_t count() const { return hands_.size(); }
  /// Hands that have had no reply for a second.
  std::size_t silent(Nanoseconds now) const;
  /// Sessions that the server has ended.
  std::size_t ended() const { return ended_; }

 private:
  struct Hand;
  void move(Hand& hand, Nanoseconds now);
  void receive(Nanoseconds now);

  Options options_;
  Nanoseconds period_;
  int epoll_ = -1;
  std::vector<Vec3> path_;  // [m] from the start, in a frame whose z axis is the outward normal
  std::vector<std::unique_ptr<Hand>> hands_;
  Nanoseconds turn_{0};  // begin of the next turn
  std::size_t ended_ = 0;
  Reply reply_;
  Counts counts_;
};

/// The time of the monotonic clock.
Nanoseconds now() noexcept;

}  // namespace feltwire::load
