#pragma once
// Measures how long a scene takes to answer a hand, when it is loaded.

#include <functional>
#include <optional>
#include <string>

#include "core/scene/scene.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// The time that a session takes to answer one sample, without sending and receiving.
struct AnswerTime {
  double usual = 0.0, slow = 0.0;  // [s] the median, and the time that one in ten exceeds
  std::size_t answers = 0;         // number of measured answers
};

/// Measures the answers to hands near the scene's objects, in contact or not, with one tool
/// (Scene::view). The hands are at points drawn evenly from the bounding balls of the objects, the
/// same points each time, and move by 1 mm a sample. Takes some 0.2 s, and longer only where a few
/// answers take that long.
AnswerTime measure_answers(const Scene& scene,
                           const std::function<Nanoseconds()>& clock = monotonic_now,
                           std::string_view tool = {});

/// A warning where one answer in ten takes longer than the usual servo period; it names the tool.
/// Nothing where all tools are fast enough.
std::optional<std::string> warning_of_slow_answers(
    const Scene& scene, const std::function<Nanoseconds()>& clock = monotonic_now);

}  // namespace feltwire
