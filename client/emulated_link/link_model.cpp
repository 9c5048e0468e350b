#include "client/emulated_link/link_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

// Purposes of the random numbers of a datagram. Each purpose has its own number, so that an option
// does not change the random effects of the other options.
enum Draw : std::uint64_t { kLoss, kDelay, kDelay2, kReorder, kDuplicate, kCopy, kCopy2, kDraws };

constexpr double kNanoseconds = 1e9;

/// Returns a random value with zero mean and unit variance. Computes it from two numbers u and v,
/// which are uniform on (0, 1). These formulas give equal values on all platforms;
/// std::normal_distribution does not.
double scatter(Jitter distribution, double u, double v) noexcept {
  switch (distribution) {
    case Jitter::normal:  // Box-Muller transform, 1958
      return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
    case Jitter::uniform:
      return std::numbers::sqrt3 * (2.0 * u - 1.0);
    case Jitter::pareto: {
      // Pareto distribution of shape 3 and scale 1, as in netem. u^(-1/3) has mean 3/2 and variance
      // 3/4.
      constexpr double kMean = 1.5, kDeviation = 0.5 * std::numbers::sqrt3;
      return (1.0 / std::cbrt(u) - kMean) / kDeviation;
    }
  }
  return 0.0;
}

}  // namespace

LinkModel::LinkModel(LinkOptions options, std::uint64_t key)
    : options_(std::move(options)), key_(key) {
  set_chain();
}

void LinkModel::set_chain() noexcept {
  // Two-state Markov chain (Gilbert model) with the probabilities `fall_ill_` to enter and
  // `recover_` to leave the loss state. A run of losses has the mean length 1 / recover_. In
  // equilibrium, loss * recover_ = (1 - loss) * fall_ill_. With recover_ = 1 - loss, the losses are
  // independent.
  const double loss = options_.loss;
  recover_ = options_.burst > 0.0 ? 1.0 / options_.burst : 1.0 - loss;
  fall_ill_ = loss < 1.0 ? loss * recover_ / (1.0 - loss) : 1.0;
}

std::optional<std::string> LinkModel::refuses(const LinkQuality& link) const {
  if (auto no = wrong(link)) return no;
  LinkOptions next;
  next.delay = link.delay;
  next.jitter = link.jitter;
  next.loss = link.loss;
  next.burst = options_.burst;
  next.trace = options_.trace;
  try {
    validate(next);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return std::nullopt;
}

void LinkModel::set(const LinkQuality& link) noexcept {
  options_.delay = link.delay;
  options_.jitter = link.jitter;
  options_.loss = link.loss;
  set_chain();
}

/// Returns a random number, uniform on the open interval (0, 1), for the purpose `draw`.
double LinkModel::uniform(std::uint64_t draw) const noexcept {
  const std::uint64_t bits = splitmix::draw(key_, ordinal_ * kDraws + draw);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1.0p-53;
}

bool LinkModel::next_is_lost() noexcept {
  const double u = uniform(kLoss);
  if (ordinal_ == 0)
    bad_ = u < options_.loss;
  else
    bad_ = bad_ ? u >= recover_ : u < fall_ill_;
  return bad_;
}

bool LinkModel::leaves_queue(std::size_t size, Nanoseconds now, Nanoseconds& leaves) noexcept {
  leaves = now;
  if (options_.rate <= 0.0) return true;
  constexpr double kBits = 8.0;  // per byte
  const auto bytes = static_cast<double>(size + kHeadersOnTheWire);
  const Nanoseconds starts = std::max(now, line_free_);
  const double waiting =
      static_cast<double>((starts - now).count()) / kNanoseconds * options_.rate / kBits;
  if (waiting + bytes > options_.queue) return false;
  leaves = line_free_ = starts + from_seconds(bytes * kBits / options_.rate);
  return true;
}

Nanoseconds LinkModel::delay(std::uint64_t draw) const noexcept {
  double seconds = options_.delay;
  if (options_.jitter > 0.0)
    seconds += options_.jitter * scatter(options_.distribution, uniform(draw), uniform(draw + 1));
  return from_seconds(std::clamp(seconds, 0.0, 2.0 * kLongestLinkDelay));
}

/// Returns the arrival time. With `keep_order`, it is not before the arrivals of earlier datagrams.
Nanoseconds LinkModel::in_order(Nanoseconds arrival) noexcept {
  if (!options_.keep_order) return arrival;
  return newest_arrival_ = std::max(newest_arrival_, arrival);
}

LinkFate LinkModel::next(std::size_t size, Nanoseconds now) noexcept {
  if (ordinal_ == 0) start_ = newest_arrival_ = now;
  const LinkTrace::Row* recorded = options_.trace ? &options_.trace->at(now - start_) : nullptr;
  const bool lost = next_is_lost() || (recorded != nullptr && recorded->lost);

  LinkFate fate;
  Nanoseconds leaves;
  if (!leaves_queue(size, now, leaves)) {
    fate.loss = LinkFate::Loss::queue;
  } else if (lost) {
    fate.loss = LinkFate::Loss::line;
  } else {
    const auto arrival = [&](std::uint64_t draw) {
      return leaves + (recorded != nullptr ? recorded->delay : delay(draw));
    };
    fate.copies = 1;
    if (uniform(kReorder) < options_.reorder) {
      // Leave the extra delay out of newest_arrival_, so that later datagrams can overtake this
      // datagram.
      const Nanoseconds latest = options_.keep_order ? newest_arrival_ : Nanoseconds(0);
      fate.arrivals[0] = std::max(latest, arrival(kDelay)) + from_seconds(options_.reorder_delay);
    } else {
      fate.arrivals[0] = in_order(arrival(kDelay));
    }
    if (uniform(kDuplicate) < options_.duplicate) {
      fate.copies = 2;
      fate.arrivals[1] = in_order(arrival(kCopy));
    }
  }
  ++ordinal_;
  return fate;
}

std::uint64_t link_key(std::uint64_t seed, std::uint64_t client, LinkDirection direction) noexcept {
  return splitmix::draw(seed, 2 * client + static_cast<std::uint64_t>(direction));
}

}  // namespace feltwire
