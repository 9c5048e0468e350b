#include "server/scene/answer_time.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/splitmix.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/broad_phase.hpp"
#include "server/scene/session.hpp"

namespace feltwire {
namespace {

// Largest and smallest number of probes. A probe is a hand near an object.
constexpr std::size_t kProbes = 64, kFewestProbes = 3;
// Number of samples of each probe. The answer to the first sample is not measured.
constexpr std::uint64_t kProbeSamples = 3;
constexpr double kProbeWay = 1e-3;  // [m] movement of a probe from one sample to the next
// [m] Largest coordinate of a probe relative to an unbounded object (a plane), on each axis.
constexpr double kProbeAround = 0.05;
// After this time, no probe begins any more, except the first kFewestProbes.
constexpr Nanoseconds kProbeTime{200'000'000};

/// Returns the i-th pseudo-random number, between -1 and 1.
double probe_draw(std::uint64_t i) {
  constexpr std::uint64_t kSeed = 20;
  return std::ldexp(static_cast<double>(splitmix::draw(kSeed, i) >> 11), -52) - 1.0;
}

/// Returns the position of probe `i`.
Vec3 probe_place(const Start& start, const std::vector<Object>& objects, std::size_t i) {
  if (objects.empty()) return start.position;
  const Object& object = objects[i * objects.size() / kProbes];
  const ReachBall ball = reach_ball(object);
  const double radius = std::isfinite(ball.radius) ? ball.radius : kProbeAround;
  const Vec3 middle = std::isfinite(ball.radius) ? ball.middle : Vec3(Vec3::Zero());
  Vec3 way;
  for (int axis = 0; axis < 3; ++axis) way[axis] = probe_draw(3 * i + static_cast<unsigned>(axis));
  return object.pose.position + object.pose.orientation * Vec3(middle + radius * way);
}

control::JoinRequest probe_request(const Scene& scene) {
  control::JoinRequest request{"probe", scene.name(), builtin_devices().front(), {}};
  request.device.rotation_sensed = 3;
  return request;
}

}  // namespace

AnswerTime measure_answers(const Scene& scene, const std::function<Nanoseconds()>& clock,
                           std::string_view tool) {
  const ToolView& view = *scene.view(tool);
  const auto world = scene.mechanism() == nullptr ? nullptr : std::make_unique<World>(scene);
  std::vector<double> times;
  const Nanoseconds begin = clock();
  for (std::size_t i = 0; i < kProbes; ++i) {
    if (i >= kFewestProbes && clock() - begin > kProbeTime) break;
    // Take the probes in another order than the objects, so that the first probes are near
    // different objects.
    constexpr std::size_t kStride = 23;
    const std::size_t at = i * kStride % kProbes;
    Session session(probe_request(scene), view, world.get());
    for (std::uint64_t n = 1; n <= kProbeSamples; ++n) {
      SampleBatch batch;
      batch.count = 1;
      batch.rotation = true;
      batch.previous = n - 1;
      Sample& sample = batch.samples[0];
      sample.index = n;
      sample.client_time = std::chrono::milliseconds(n);
      sample.pose.position = probe_place(scene.start(), view.objects(), at) +
                             Vec3(0, 0, -kProbeWay * static_cast<double>(n));
      const Nanoseconds before = clock();
      session.take(batch, before);
      if (n > 1) times.push_back(seconds(clock() - before));
    }
  }
  std::ranges::sort(times);
  return {times[times.size() / 2], times[times.size() * 9 / 10], times.size()};
}

std::optional<std::string> warning_of_slow_answers(const Scene& scene,
                                                   const std::function<Nanoseconds()>& clock) {
  constexpr double kMilliseconds = 1e3;  // [ms/s]
  const double period = SessionParameters{}.servo_period;
  for (const ToolView& view : scene.views()) {
    const AnswerTime time = measure_answers(scene, clock, view.tool().name);
    if (!(time.slow > period)) continue;
    const std::string tool =
        view.tool().name.empty() ? "" : " to a hand with tool '" + view.tool().name + "'";
    return fmt::format(
        "an answer{} near its objects takes {:.2g} ms on this machine now ({:.2g} ms one in ten of "
        "{} asked), longer than the usual servo period of {} ms: forces come late, and not every "
        "sample is answered; simplify the scene, or have clients ask for a longer servo period",
        tool, kMilliseconds * time.usual, kMilliseconds * time.slow, time.answers,
        kMilliseconds * period);
  }
  return std::nullopt;
}

}  // namespace feltwire
