#include "client/run/observer_recorder.hpp"

#include <algorithm>

namespace feltwire {

namespace {

std::string text(const std::vector<LinkState>& robots) {
  if (robots.empty()) return {};
  std::string states;
  for (const LinkState state : robots)
    states += (states.empty() ? "" : ", ") + std::string(name(state));
  return (robots.size() == 1 ? ", a robot (" : ", " + std::to_string(robots.size()) + " robots (") +
         states + ")";
}

}  // namespace

std::string text(const SightCounts& counts) {
  return "  sees " + std::to_string(counts.hands) + (counts.hands == 1 ? " hand, " : " hands, ") +
         std::to_string(counts.bodies) + (counts.bodies == 1 ? " body" : " bodies") +
         text(counts.robots) +
         (counts.left_out > 0 ? ", " + std::to_string(counts.left_out) + " left out" : "");
}

ObserverRecorder::ObserverRecorder(const std::optional<std::filesystem::path>& file, OnView on_view)
    : file_(file ? std::make_unique<ViewFile>(*file) : nullptr), on_view_(std::move(on_view)) {}

void ObserverRecorder::look() {
  while (views_.pop(shown_)) {
    scene_.take(shown_.view);
    ++counts_.views;
    counts_.hands = scene_.hands().size();
    counts_.bodies = scene_.bodies().size();
    counts_.robots.clear();
    for (const auto& [seat, robot] : scene_.robots()) counts_.robots.push_back(robot.state);
    counts_.left_out = scene_.left_out();
    counts_.most_hands = std::max(counts_.most_hands, counts_.hands);
    counts_.most_bodies = std::max(counts_.most_bodies, counts_.bodies);
    if (file_) file_->add(shown_, scene_);
    if (on_view_) on_view_(shown_.time, scene_);
  }
  if (file_) file_->write();
}

void ObserverRecorder::finish() {
  if (file_) file_->finish();
}

}  // namespace feltwire
