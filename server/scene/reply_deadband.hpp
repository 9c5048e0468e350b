#pragma once
// Which replies need not be sent: the client already makes the same of the last one.

#include "protocol/session/deadband.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Whether the surfaces of `now` are those that `sent` said, `since` [s] ago: each lies where it
/// said within `force` [N] over its stiffness, and the tool at now.center is not beyond half of
/// what `sent` reaches and knows. A model without reach describes nothing.
bool describes(const LocalModel& sent, const LocalModel& now, double since, double force) noexcept;

/// A force deadband: a reply is withheld while the command differs from what the client
/// reconstructs by no more than a Weber fraction (protocol/session/deadband.hpp). Reconstructs with
/// the client's own function, over the client's own sample times, so without losses the two agree.
///
/// Replies get lost, and the server does not hear of it: what the client really holds may then be
/// the reply before, and wrong by more. It is so for keep_alive at most, then a reply is sent
/// whatever it says. Sent at once is also whatever begins or ends: contact, a refusal, saturation;
/// a gap; and all while what moves was put back, for then surfaces change that no model tells of.
///
/// A client with a local model makes the force itself where it is: what it must be told is not the
/// force but surfaces that the model it has does not describe any more, or that the tool is half
/// way out of it.
class ReplyDeadband {
 public:
  /// `parameters` must be valid. Without a force deadband nothing is ever withheld.
  explicit ReplyDeadband(const SessionParameters& parameters) : parameters_(parameters) {}

  bool on() const { return parameters_.force_deadband > 0.0; }

  /// The command of one more sample, `elapsed` [s] after the one before.
  void add(const Command& command, double elapsed) noexcept {
    since_ += elapsed;
    if (on() && parameters_.predictor == Predictor::linear) trend_.add(command, elapsed);
  }

  /// Completes the reply to the last sample added (`rates`) and says whether it may be withheld. If
  /// not, it counts as sent.
  bool withhold(Reply& reply) noexcept;

 private:
  bool differs(const Reply& reply) const noexcept;

  SessionParameters parameters_;
  CommandTrend trend_;
  // The reply that was sent last.
  bool any_ = false, refused_ = false, saturated_ = false, recovering_ = false;
  Command command_, rates_;
  LocalModel model_;    // of reach 0: none
  double since_ = 0.0;  // [s] of the client's samples since that reply's
};

}  // namespace feltwire
