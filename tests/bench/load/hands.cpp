#include "tests/bench/load/hands.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <system_error>
#include <utility>

#include "client/hands/hand_path.hpp"
#include "core/base/splitmix.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire::load {
namespace {

constexpr std::chrono::milliseconds kJoinTimeout{20'000};
constexpr Nanoseconds kSilent = std::chrono::seconds(1);
constexpr Nanoseconds kPlace = std::chrono::microseconds(50);  // of the hands in a turn
constexpr int kEventsAtOnce = 256;
constexpr double kLoop = 4.0;  // [s] after this time the path begins again

Nanoseconds time_of(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + Nanoseconds(time.tv_nsec);
}

void sleep_until(Nanoseconds time) noexcept {
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(time);
  const timespec until{whole.count(), (time - whole).count()};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

/// A hand that slides over the surface. It leaves the surface and comes back once in a loop.
std::vector<Vec3> path(double depth, double period) {
  HandTask slide;
  slide.path = HandPath::slide;
  slide.radius = 0.02;
  slide.depth = depth;
  slide.lead_in = 0.25 * kLoop;
  const IntendedMotion motion(slide);
  std::vector<Vec3> points;
  const auto count = static_cast<std::size_t>(kLoop / period);
  for (std::size_t i = 0; i < count; ++i) {
    const double t = period * static_cast<double>(i);
    Vec3 point = motion.position(t);
    const double end = smoothstep((t - 0.75 * kLoop) / (0.25 * kLoop));
    point += end * (motion.position(0.0) - point);
    points.push_back(point);
  }
  return points;
}

/// The rotation that turns the z axis to `normal`.
Quaternion turned_to(const Vec3& normal) {
  return Quaternion::FromTwoVectors(Vec3::UnitZ(), normal);
}

}  // namespace

Nanoseconds now() noexcept { return time_of(CLOCK_MONOTONIC); }

struct Hands::Hand {
  std::unique_ptr<Transport> transport;
  Vec3 start;
  Quaternion turn;
  std::uint64_t phase = 0;  // in the path
  Sample sample;
  Nanoseconds reported{0}, heard{0};
  bool ended = false;
};

Hands::Hands(const Options& options)
    : options_(options),
      period_(from_seconds(options.parameters.servo_period)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      path_(path(options.depth, options.parameters.servo_period)),
      turn_(now()) {
  if (epoll_ < 0) throw std::system_error(errno, std::generic_category(), "epoll_create1");
}

Hands::~Hands() {
  for (const auto& hand : hands_) hand->transport->goodbye();
  ::close(epoll_);
}

void Hands::join_one() {
  const Joined joined = join(
      options_.server, {"load", options_.scene, builtin_device("simulated"), options_.parameters},
      kJoinTimeout);
  auto hand = std::make_unique<Hand>();
  hand->transport = std::make_unique<Transport>(
      SessionAddress{joined.datagrams, joined.accepted.session, joined.keys},
      joined.accepted.parameters, false);
  hand->start = joined.accepted.start_position;
  hand->turn = turned_to(joined.accepted.start_normal);
  hand->phase = splitmix::draw(options_.seed, hands_.size()) % path_.size();
  hand->heard = now();
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.ptr = hand.get();
  if (::epoll_ctl(epoll_, EPOLL_CTL_ADD, hand->transport->port().descriptor(), &event) != 0)
    throw std::system_error(errno, std::generic_category(), "epoll_ctl");
  hands_.push_back(std::move(hand));
}

void Hands::move(Hand& hand, Nanoseconds at) {
  if (hand.ended) return;
  ++hand.sample.index;
  hand.sample.client_time = at;
  const Vec3& point = path_[(hand.phase + hand.sample.index) % path_.size()];
  hand.sample.pose.position = hand.start + hand.turn * point;
  std::optional<HandReport> report;
  if (seconds(at - hand.reported) >= kBetweenReports) report.emplace();
  if (!hand.transport->send(hand.sample, report)) return;
  if (report) hand.reported = at;
  ++counts_.datagrams;
}

void Hands::receive(Nanoseconds at) {
  std::array<epoll_event, kEventsAtOnce> events;
  const int count = ::epoll_wait(epoll_, events.data(), kEventsAtOnce, 0);
  for (int i = 0; i < count; ++i) {
    Hand& hand = *static_cast<Hand*>(events[static_cast<std::size_t>(i)].data.ptr);
    GoodbyeReason reason{};
    while (true) {
      const Transport::Arrival arrival = hand.transport->receive(reply_, reason);
      if (arrival == Transport::Arrival::nothing) break;
      if (arrival == Transport::Arrival::goodbye) {
        ended_ += hand.ended ? 0 : 1;
        hand.ended = true;
        continue;
      }
      ++counts_.replies;
      if (reply_.command.elastic.squaredNorm() > 0.0) ++counts_.with_force;
      counts_.round_trip.record((at - reply_.client_time).count());
      hand.sample.held = reply_.command;
      hand.heard = at;
    }
  }
}

void Hands::run_until(Nanoseconds end) {
  while (turn_ < end) {
    // Do not make up for lost turns, because the server would get their samples at once.
    while (now() >= turn_ + period_) {
      turn_ += period_;
      ++counts_.skipped;
    }
    const auto places = static_cast<std::size_t>(std::max<std::int64_t>(period_ / kPlace, 1));
    for (std::size_t place = 0; place < places; ++place) {
      sleep_until(turn_ + static_cast<std::int64_t>(place) * kPlace);
      receive(now());
      for (std::size_t i = place; i < hands_.size(); i += places) move(*hands_[i], now());
    }
    turn_ += period_;
  }
}

Counts Hands::take_counts() { return std::exchange(counts_, {}); }

std::size_t Hands::silent(Nanoseconds at) const {
  std::size_t result = 0;
  for (const auto& hand : hands_) result += at - hand->heard > kSilent ? 1 : 0;
  return result;
}

}  // namespace feltwire::load
