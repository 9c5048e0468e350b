#pragma once
// How long a scene takes to answer a hand, measured when it is loaded.

#include <functional>
#include <optional>
#include <string>

#include "core/scene/scene.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// What one sample after another of a session takes, without its datagrams.
struct AnswerTime {
  double usual = 0.0, slow = 0.0;  // [s] the median, and what one in ten takes at least
  std::size_t answers = 0;         // measured
};

/// Of hands near the scene's objects, in contact or not, with this tool (Scene::view): at points
/// drawn evenly from the balls around them, the same ones each time, each with a way of 1 mm a
/// sample. Takes some 0.2 s, and longer only where a few answers alone do.
AnswerTime measure_answers(const Scene& scene,
                           const std::function<Nanoseconds()>& clock = monotonic_now,
                           std::string_view tool = {});

/// What there is to warn of: a tool with which one answer in ten takes longer than the usual servo
/// period.
std::optional<std::string> warning_of_slow_answers(
    const Scene& scene, const std::function<Nanoseconds()>& clock = monotonic_now);

}  // namespace feltwire
