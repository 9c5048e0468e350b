#pragma once
// The effect of a link on the datagrams of a session, in closed form (docs/lab/advise.md).

#include "client/emulated_link/link_options.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire::advise {

/// Datagrams of `bytes`, headers on the wire included, that enter every `interval` [s].
struct Flow {
  double interval = 0.0;
  double bytes = 0.0;
  double kbit_per_second() const { return 8e-3 * bytes / interval; }
};

/// [s] The mean time on the way: the mean delay, the time on the slowest line, and the time for
/// which a datagram waits for those before it, where the link keeps their order.
double mean_delay(const LinkOptions& link, const Flow& flow);

/// The share of the datagrams that is lost, and the mean run of losses [datagrams], at least 1.
struct Losses {
  double share = 0.0;
  double run = 1.0;
};
Losses losses(const LinkOptions& link);
/// A datagram that needs both ways.
Losses both_ways(const Losses& up, const Losses& down);

/// The gaps between two arrivals, in intervals: their mean, and the ratio of the mean square to the
/// mean. Both are 1 without losses.
struct Gaps {
  double mean = 1.0;
  double square_over_mean = 1.0;
};
Gaps gaps(const Losses& losses);

/// The share of a command that is left, in the mean over time, where commands fade from half of
/// `hold_time` [s] on and a new one is due every `interval` [s].
double mean_fade(const Losses& losses, double interval, double hold_time);

/// [s] The time since the sample was taken that the newest reply answers, in the mean over the
/// ticks of the servo.
struct NewsAge {
  double link = 0.0;  // of it the mean delays of both ways, as the link was given
  double total = 0.0;
  double added() const { return total - link; }
};
/// `up`, `down`: the datagrams of the two directions. A reply answers every datagram, or is due
/// every `down.interval`.
NewsAge news_age(const TwoWayLinkOptions& link, const Flow& up, const Flow& down,
                 double servo_period);

}  // namespace feltwire::advise
