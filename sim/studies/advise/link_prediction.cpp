#include "sim/studies/advise/link_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace feltwire::advise {
namespace {

constexpr int kWaitingMost = 4000;  // datagrams before one that it may wait for
constexpr int kSteps = 2000;        // of the integral over the waiting time
constexpr double kFarthest = 12.0;  // [standard deviations] of a delay that is looked at
constexpr double kFullLine = 0.95;  // of a line's rate; above it datagrams wait without end

/// Returns the probability that X <= z, where X has mean 0 and variance 1.
double standard_share_below(Jitter distribution, double z) {
  switch (distribution) {
    case Jitter::normal:
      return 0.5 * std::erfc(-z / std::numbers::sqrt2);
    case Jitter::uniform:
      return std::clamp(0.5 * (z / std::numbers::sqrt3 + 1.0), 0.0, 1.0);
    case Jitter::pareto: {
      // Shape 3, scale 1: mean 3/2 and variance 3/4, as the emulator draws it.
      const double x = 1.5 + 0.5 * std::numbers::sqrt3 * z;
      return x <= 1.0 ? 0.0 : 1.0 - 1.0 / (x * x * x);
    }
  }
  return 0.0;
}

struct Delay {
  double mean = 0.0, deviation = 0.0;  // [s]
};

/// The delay of a link by its options, or by the mean of its trace.
Delay delay_of(const LinkOptions& link) {
  if (!link.trace) return {link.delay, link.jitter};
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const auto& row : link.trace->rows) {
    if (row.lost) continue;
    const double delay = seconds(row.delay);
    sum += delay, squares += delay * delay, count += 1.0;
  }
  if (!(count > 0.0)) return {};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

/// Returns the mean time by which a datagram is later than its mean delay, because it waits for
/// those before it: E[max over j of (X_0, X_j - j interval)], of those that are not lost.
double waiting(const LinkOptions& link, const Delay& delay, double interval) {
  if (!(delay.deviation > 0.0) || !link.keep_order) return 0.0;
  const double step = interval / delay.deviation;
  const int before = std::min(kWaitingMost, static_cast<int>(kFarthest / step) + 1);
  const double low = std::max(-kFarthest, -delay.mean / delay.deviation);
  const auto all_below = [&](double z) {
    double share = standard_share_below(link.distribution, z);
    for (int j = 1; j <= before && share > 0.0; ++j)
      share *=
          link.loss + (1.0 - link.loss) * standard_share_below(link.distribution, z + j * step);
    return share;
  };
  // The mean of a maximum of at least `low` is low + the integral of 1 - F.
  double mean = low;
  const double width = (kFarthest - low) / kSteps;
  for (int n = 0; n < kSteps; ++n) mean += width * (1.0 - all_below(low + (n + 0.5) * width));
  return std::max(0.0, mean) * delay.deviation;
}

}  // namespace

double mean_delay(const LinkOptions& link, const Flow& flow) {
  const Delay delay = delay_of(link);
  double time = delay.mean + waiting(link, delay, flow.interval);
  if (!(link.rate > 0.0)) return time;
  const double on_line = 8.0 * flow.bytes / link.rate;
  time += on_line;
  // Above the line's rate the queue is full: what is in it must leave first.
  if (on_line > kFullLine * flow.interval) time += 8.0 * link.queue / link.rate;
  return time;
}

Losses losses(const LinkOptions& link) {
  if (link.trace) {
    double lost = 0.0, runs = 0.0;
    bool before = false;
    for (const auto& row : link.trace->rows) {
      lost += row.lost ? 1.0 : 0.0;
      runs += row.lost && !before ? 1.0 : 0.0;
      before = row.lost;
    }
    return {lost / static_cast<double>(link.trace->rows.size()), runs > 0.0 ? lost / runs : 1.0};
  }
  if (!(link.loss > 0.0)) return {};
  return {link.loss, link.burst > 0.0 ? link.burst : 1.0 / (1.0 - std::min(link.loss, 0.999))};
}

Losses both_ways(const Losses& up, const Losses& down) {
  const double share = up.share + (1.0 - up.share) * down.share;
  if (!(share > 0.0)) return {};
  // Runs of both directions follow each other; each counts by its share.
  const double run = (up.share * up.run + down.share * down.run) / (up.share + down.share);
  return {share, run};
}

Gaps gaps(const Losses& losses) {
  if (!(losses.share > 0.0) || losses.share >= 1.0) return {};
  // A run begins after an arrival with the probability f, and has a geometric length of mean B.
  const double run = std::max(1.0, losses.run);
  const double begins = std::min(1.0, losses.share / (run * (1.0 - losses.share)));
  const double mean = 1.0 + begins * run;
  const double square = 1.0 + begins * (run + 2.0 * run * run);
  return {mean, square / mean};
}

double mean_fade(const Losses& losses, double interval, double hold_time) {
  const double half = 0.5 * hold_time;
  // Integral over the age of what is left of a command, up to an age.
  const auto left_until = [&](double age) {
    if (age <= half) return age;
    const double over = std::min(age, hold_time) - half;
    return half + over - 0.5 * over * over / half;
  };
  if (losses.share >= 1.0) return 0.0;
  const double run = std::max(1.0, losses.run);
  const double begins = std::min(1.0, losses.share / (run * (1.0 - losses.share)));
  const double ends = 1.0 / run;
  double felt = (1.0 - begins) * left_until(interval), time = (1.0 - begins) * interval;
  double share = begins * ends;
  constexpr double kRare = 1e-12;
  for (int gap = 2; share > kRare && gap < kWaitingMost; ++gap) {
    felt += share * left_until(gap * interval);
    time += share * gap * interval;
    share *= 1.0 - ends;
  }
  return time > 0.0 ? felt / time : 0.0;
}

NewsAge news_age(const TwoWayLinkOptions& link, const Flow& up, const Flow& down,
                 double servo_period) {
  const Delay there = delay_of(link.up), back = delay_of(link.down);
  NewsAge age;
  age.link = there.mean + back.mean;
  const double way = mean_delay(link.up, up) + mean_delay(link.down, down);
  // A reply counts from the first tick after it. Without jitter that is always the same one.
  const bool steady = std::hypot(there.deviation, back.deviation) < 0.25 * servo_period;
  constexpr double kRounding = 1e-9;
  const double first =
      steady ? std::ceil(way / servo_period - kRounding) * servo_period : way + 0.5 * servo_period;
  const bool each = !(down.interval > 1.5 * up.interval);
  const Losses lost = each ? both_ways(losses(link.up), losses(link.down)) : losses(link.down);
  const double until_next = gaps(lost).square_over_mean * down.interval;
  age.total = std::max(first, servo_period) + 0.5 * (until_next - servo_period);
  return age;
}

}  // namespace feltwire::advise
