#include "sim/studies/advise/scene_facts.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "core/grid/distance_grid.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/mechanism.hpp"
#include "core/tool/body_tool.hpp"
#include "protocol/wire/codec.hpp"

namespace feltwire::advise {
namespace {

constexpr double kPressedDepth = 1e-3;  // [m] depth at which a place is touched
constexpr int kTimedCalls = 400;        // calls in a measurement, of which the median counts
constexpr int kCallsAtOnce = 16;        // calls between two looks at the clock

void add_shape(const Object& object, SceneFacts& facts) {
  if (const auto* mesh = std::get_if<Mesh>(&object.shape)) {
    ++facts.meshes;
    facts.triangles += mesh->surface->mesh().triangles().size();
    facts.geometry_bytes += mesh->surface->memory();
  } else if (const auto* grid = std::get_if<Grid>(&object.shape)) {
    ++facts.grids;
    facts.geometry_bytes += grid->field->bytes();
  }
}

void add_material(const Object& object, SceneFacts& facts) {
  const auto same = [&](const Place& known) {
    return known.material.stiffness == object.material.stiffness &&
           known.material.static_friction == object.material.static_friction &&
           known.material.damping == object.material.damping;
  };
  if (std::ranges::none_of(facts.materials, same))
    facts.materials.push_back({.object = object.name, .material = object.material});
}

/// Returns the median time [s] of a call.
template <class Call>
double time_of(const Call& call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  times.reserve(kTimedCalls);
  for (int n = 0; n < kTimedCalls; ++n) {
    const Clock::time_point begin = Clock::now();
    for (int again = 0; again < kCallsAtOnce; ++again) call();
    times.push_back(std::chrono::duration<double>(Clock::now() - begin).count() / kCallsAtOnce);
  }
  const auto middle = times.begin() + kTimedCalls / 2;
  std::ranges::nth_element(times, middle);
  return *middle;
}

}  // namespace

SceneFacts facts_of(const Scene& scene) {
  SceneFacts facts;
  facts.name = scene.name();
  facts.objects = scene.objects().size();
  const ToolView& view = scene;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const Object& object = scene.objects()[i];
    add_shape(object, facts);
    add_material(object, facts);
    const bool whole = std::holds_alternative<Mesh>(object.shape) && can_travel(view, i);
    if (std::holds_alternative<Mesh>(object.shape) && !whole) ++facts.meshes_beyond_travel;
  }
  std::ranges::stable_sort(facts.materials, [](const Place& a, const Place& b) {
    return a.material.stiffness > b.material.stiffness;
  });
  facts.friction = scene.requirements().friction;
  facts.guides = scene.requirements().guides;
  facts.stiffest = scene.requirements().stiffness;
  if (scene.mechanism()) {
    facts.moving = scene.mechanism()->parts().size();
    facts.tick = scene.mechanism()->model().opt.timestep;
  }
  for (const ToolView& tool : scene.views())
    if (const auto& body = tool.tool().body) {
      facts.points = std::max(facts.points, body->shell().points.size());
      facts.polygons = facts.polygons || body->polygons() != nullptr;
    }
  if (facts.materials.empty() && !facts.guides)
    throw std::invalid_argument("scene '" + scene.name() +
                                "' has no object and no guide; there is nothing to feel");
  return facts;
}

PlaceCost cost_at(const Scene& scene, const Place& place, bool modelled, bool rotation) {
  PlaceCost cost;
  const ToolView& view = scene;
  TouchMemory memory = view.memory();
  const Tool tool{place.point - kPressedDepth * place.normal, Vec3::Zero()};
  Reply reply;
  reply.rotation = rotation;
  // Values that are zero do not travel.
  reply.sample_index = reply.withheld = 1;
  reply.client_time = reply.server_times.received = reply.server_times.sent = Nanoseconds(1);
  reply.delivered = {.elastic = 1.0, .frictional = 1.0};
  reply.command = view.touch(tool, memory);
  cost.touch = time_of([&] { reply.command = view.touch(tool, memory); });
  if (modelled) {
    KnownSurfaces known;
    for (std::size_t i = 0; i < view.objects().size(); ++i)
      known.push_back(i < view.still() && can_travel(view, i));
    reply.modelled = true;
    reply.model = local_model(view, tool.position, memory, known);
    cost.model = time_of([&] { reply.model = local_model(view, tool.position, memory, known); });
    cost.patches = reply.model.view().size();
    cost.reach = reply.model.reach;
  }
  Encoder encoder;
  cost.reply_bytes = encoder.reply(reply).size();
  return cost;
}

}  // namespace feltwire::advise
