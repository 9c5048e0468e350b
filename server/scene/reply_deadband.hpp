#pragma once
// Decides which replies need not be sent, because the client computes the same from the last one.

#include "protocol/session/deadband.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Whether the surfaces of `now` are those of `sent`, `since` [s] ago: each lies at its predicted
/// place within `force` [N] over its stiffness, and the tool at now.center is within half of the
/// reach of `sent`. A model without reach describes nothing.
bool describes(const LocalModel& sent, const LocalModel& now, double since, double force) noexcept;

/// A force deadband: a reply is withheld while the command differs from what the client
/// reconstructs by no more than a Weber fraction (protocol/session/deadband.hpp). Reconstructs with
/// the client's own function, over the client's own sample times, so without losses the two agree.
///
/// Replies may be lost, and the server does not know it: then the client may hold the force of the
/// reply before, with a larger error. This lasts for keep_alive at most, because then a reply is
/// always sent. A reply is also sent at once if contact, a refusal or saturation begins or ends,
/// after a gap, and while moving objects were put back, because then surfaces change that no model
/// describes.
///
/// A client with a local model makes the force itself. It needs a reply only if its model no longer
/// describes the surfaces, or if the tool is half way out of it.
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

  /// Completes the reply to the last sample added (`rates`) and returns whether it may be withheld.
  /// If not, it counts as sent.
  bool withhold(Reply& reply) noexcept;

 private:
  bool differs(const Reply& reply) const noexcept;

  SessionParameters parameters_;
  CommandTrend trend_;
  // The reply that was sent last.
  bool any_ = false, refused_ = false, saturated_ = false, recovering_ = false;
  Command command_, rates_;
  LocalModel model_;    // of reach 0: none
  double since_ = 0.0;  // [s] of the client's samples since that of the reply
};

}  // namespace feltwire
