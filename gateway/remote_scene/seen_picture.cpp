#include "gateway/remote_scene/seen_picture.hpp"

#include <algorithm>
#include <stdexcept>

#include "protocol/session/material_fields.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

constexpr double kSmallForce = 0.01;  // [N] a smaller force counts as no contact
constexpr std::uint32_t kKnownStates = (1u << kHandStates) - 1u;

PictureHand picture_of(const SeenHand& seen) {
  PictureHand hand;
  hand.number = seen.number;
  hand.pose = seen.pose;
  hand.held = seen.force;
  if (!seen.figures) {
    hand.proxy = seen.pose.position;
    hand.states =
        bit(seen.force.norm() > kSmallForce ? HandState::touching : HandState::free_space);
    return hand;
  }
  const HandFigures& figures = *seen.figures;
  hand.states = figures.states & kKnownStates;
  hand.report = figures.report;
  hand.proxy = figures.proxy;
  hand.elastic = figures.elastic;
  hand.frictional = figures.frictional;
  hand.depth = figures.depth;
  hand.delivered = figures.delivered;
  hand.burned = figures.burned;
  hand.samples = figures.samples;
  hand.missed = figures.missed;
  return hand;
}

/// Returns the parameters, or nothing if they are invalid.
std::optional<SessionParameters> possible(const SessionParameters& parameters) {
  try {
    validate(parameters);
    return parameters;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

bool same(const Material& a, const Material& b) {
  return std::ranges::all_of(kMaterialFields, [&](const MaterialField& field) {
    return a.*field.value == b.*field.value;
  });
}

}  // namespace

const control::SessionDescription* told_of(std::span<const control::SessionDescription> told,
                                           std::uint32_t number) {
  const auto found =
      std::ranges::lower_bound(told, number, {}, &control::SessionDescription::number);
  return found != told.end() && found->number == number ? &*found : nullptr;
}

void draw(const ObservedScene& seen, const Scene& scene,
          std::span<const control::SessionDescription> told, Picture& picture) {
  picture.hands.clear();
  picture.bodies.clear();
  picture.robots.clear();
  for (const auto& [seat, robot] : seen.robots()) picture.robots.push_back(robot);
  for (const auto& [number, hand] : seen.hands()) {
    PictureHand& drawn = picture.hands.emplace_back(picture_of(hand));
    if (const auto* session = told_of(told, number); session != nullptr && drawn.report)
      drawn.report->hand_damping = session->hand_damping.value_or(0.0);
  }
  const std::size_t still = scene.views().front().still(), end = scene.objects().size();
  for (const auto& [object, body] : seen.bodies())
    if (object >= still && object < end) picture.bodies.push_back({object, body.pose});
}

std::vector<HandDescription> hands_of(const ObservedScene& seen, const Scene& scene,
                                      std::span<const control::SessionDescription> told,
                                      Nanoseconds now) {
  std::vector<HandDescription> hands;
  for (const auto& [number, hand] : seen.hands()) {
    const std::size_t tool = hand.figures ? hand.figures->tool : 0;
    HandDescription& described = hands.emplace_back();
    described.number = number;
    if (tool < scene.views().size()) described.tool = scene.views()[tool].tool().name;
    const control::SessionDescription* session = told_of(told, number);
    if (session == nullptr) continue;
    described.session = session->session;
    described.client = session->client;
    described.device = session->device;
    described.parameters = possible(session->parameters);
    described.changes = session->changes;
    described.times = session->times;
    if (!scene.seats().empty() && covers(session->role, Role::operator_))
      described.lead_share = session->lead_share;
    constexpr double kLongest = 1e9;  // [s] about 30 years, which fits into Nanoseconds
    if (session->seconds && *session->seconds >= 0.0 && *session->seconds < kLongest)
      described.joined = now - from_seconds(*session->seconds);
  }
  return hands;
}

std::optional<Scene> with_materials(const Scene& scene, std::span<const Material> materials) {
  if (materials.size() != scene.objects().size()) return std::nullopt;
  std::optional<Scene> changed;
  try {
    for (std::size_t i = 0; i < materials.size(); ++i) {
      if (same(materials[i], scene.objects()[i].material)) continue;
      if (!changed) changed = scene;
      changed->set_material(i, materials[i]);
    }
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
  return changed;
}

}  // namespace feltwire
