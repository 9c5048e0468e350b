#include "server/control/shape_requests.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <asio/post.hpp>
#include <cmath>
#include <exception>
#include <string>
#include <variant>
#include <vector>

#include "core/geometry/shape_lengths.hpp"
#include "core/grid/isosurface.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/scene.hpp"
#include "core/tool/body_tool.hpp"
#include "protocol/net/post.hpp"
#include "protocol/net/real_time.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;
using control::ShapeGroup;

constexpr int kGridSteps = 64;  // along the longest side of a grid

std::string short_name(const std::string& name) {
  return control::shortened(name, control::kMaxName);
}

/// Writes the name and the numbers of a primitive; false: the shape is none.
template <class Variant>
bool describe_primitive(const Variant& shape, control::ShapeDescription& described) {
  return on_primitive(
      shape,
      [&](const auto& primitive) {
        described.shape = primitive.kName;
        described.lengths = lengths_of(primitive);
        return true;
      },
      [] { return false; });
}

/// The mesh of an object, also where a tool with a body feels a grid of it; null: it is none.
const MeshSurface* shown_mesh(const ToolView& view, std::size_t index) {
  if (const MeshSurface* sampled = view.sampled_mesh(index)) return sampled;
  const auto* mesh = std::get_if<Mesh>(&view.objects()[index].shape);
  return mesh != nullptr ? mesh->surface.get() : nullptr;
}

control::ShapeDescription described(const ToolView& view, std::size_t index) {
  const Object& object = view.objects()[index];
  control::ShapeDescription shape;
  shape.name = short_name(object.name);
  shape.pose = object.pose;
  shape.moves = index >= view.still();
  shape.from_inside = object.felt_from == Side::inside;
  shape.material = short_name(object.material_name);
  if (describe_primitive(object.shape, shape)) return shape;
  shape.parts = true;
  shape.shape = shown_mesh(view, index) != nullptr ? "mesh" : "grid";
  return shape;
}

control::ShapeDescription described(const Guide& guide) {
  static constexpr std::array<const char*, 5> kActions = {"attract", "keep_out", "magnet",
                                                          "viscosity", "constant"};
  control::ShapeDescription shape;
  shape.name = short_name(guide.name);
  shape.pose = guide.pose;
  shape.action = kActions.at(guide.action.index());
  if (describe_primitive(guide.place, shape)) return shape;
  if (const auto* line = std::get_if<GuideLine>(&guide.place)) {
    shape.shape = "line";
    if (std::isfinite(line->half_length)) shape.lengths = {line->half_length};
  } else if (const auto* curve = std::get_if<GuideCurve>(&guide.place)) {
    shape.shape = "curve";
    shape.closed = curve->closed;
    shape.parts = true;
  } else {
    shape.shape = std::holds_alternative<GuidePoint>(guide.place) ? "point" : "everywhere";
  }
  return shape;
}

control::ShapeDescription described(const HandTool& tool) {
  control::ShapeDescription shape;
  shape.name = short_name(tool.name);
  shape.shape = "point";
  if (tool.radius > 0.0) {
    shape.shape = Sphere::kName;
    shape.lengths = {tool.radius};
  }
  if (tool.body == nullptr) return shape;
  shape.shape = "points";
  shape.lengths.clear();
  shape.parts = true;
  return shape;
}

std::size_t count_of(const Scene& scene, ShapeGroup group) {
  switch (group) {
    case ShapeGroup::objects:
      return scene.objects().size();
    case ShapeGroup::guides:
      return scene.guides().size();
    case ShapeGroup::tools:
      break;
  }
  return scene.views().size();
}

control::ShapeDescription described(const Scene& scene, ShapeGroup group, std::size_t index) {
  switch (group) {
    case ShapeGroup::objects:
      return described(scene.views().front(), index);
    case ShapeGroup::guides:
      return described(scene.guides()[index]);
    case ShapeGroup::tools:
      break;
  }
  return described(scene.views()[index].tool());
}

/// Appends the entries from index `known` on, at most control::kMaxPart of them.
template <class Entry>
void take_part(const std::vector<Entry>& all, std::uint32_t known, std::vector<Entry>& part) {
  const std::size_t first = std::min<std::size_t>(known, all.size());
  const std::size_t count = std::min(all.size() - first, control::kMaxPart);
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
  part.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
}

control::ShapePart part_of(const std::vector<Vec3>& vertices,
                           const std::vector<Triangle>& triangles,
                           const control::GetShape& request) {
  control::ShapePart part{.all_vertices = static_cast<std::uint32_t>(vertices.size()),
                          .all_triangles = static_cast<std::uint32_t>(triangles.size())};
  take_part(vertices, request.vertices, part.vertices);
  take_part(triangles, request.triangles, part.triangles);
  return part;
}

Refused no_parts() {
  return {RefusalCode::bad_parameters,
          "there is no shape with vertices at this index; DescribeShapes says which have parts"};
}

/// Returns the grid whose triangles a request asks for; null: it asks for something else.
const Grid* grid_of(const SceneInView::CurrentScene& current, const control::GetShape& request) {
  const Scene& scene = *current.scene;
  if (request.version != current.version || request.group != ShapeGroup::objects ||
      request.index >= scene.objects().size())
    return nullptr;
  const ToolView& view = scene.views().front();
  if (shown_mesh(view, request.index) != nullptr) return nullptr;
  return std::get_if<Grid>(&view.objects()[request.index].shape);
}

/// Returns the next part of a shape that is no grid, or the refusal.
control::Message part_at_once(const SceneInView::CurrentScene& current,
                              const control::GetShape& request) {
  if (request.version != current.version) return other_version(request.version, "shapes");
  if (request.index >= count_of(*current.scene, request.group)) return no_parts();
  if (request.group == ShapeGroup::tools) {
    const auto& body = current.scene->views()[request.index].tool().body;
    if (body == nullptr) return no_parts();
    return part_of(body->shell().points, {}, request);
  }
  if (request.group == ShapeGroup::guides) {
    const auto* curve = std::get_if<GuideCurve>(&current.scene->guides()[request.index].place);
    if (curve == nullptr) return no_parts();
    return part_of(curve->points, {}, request);
  }
  const MeshSurface* mesh = shown_mesh(current.scene->views().front(), request.index);
  if (mesh == nullptr) return no_parts();
  control::ShapePart part = part_of(mesh->mesh().vertices(), mesh->mesh().triangles(), request);
  for (Vec3& vertex : part.vertices) vertex += mesh->mesh().origin();
  return part;
}

}  // namespace

control::ShapeDescriptions described_shapes(const SceneInView::CurrentScene& current,
                                            const control::DescribeShapes& request) {
  const Scene& scene = *current.scene;
  const std::size_t count = count_of(scene, request.group);
  control::ShapeDescriptions list{.version = current.version,
                                  .scene = scene.description(),
                                  .count = static_cast<std::uint32_t>(count),
                                  .shapes = {}};
  for (std::size_t i = request.from; i < count && list.shapes.size() < control::kMaxShapes; ++i)
    list.shapes.push_back(described(scene, request.group, i));
  return list;
}

void ShapeParts::part(std::size_t scene, const SceneInView::CurrentScene& current,
                      const control::GetShape& request, Answer answer) {
  const auto* grid = grid_of(current, request);
  if (grid == nullptr) return answer(part_at_once(current, request));
  const Key key{scene, current.version, request.index};
  const auto [found, is_new] = grids_.try_emplace(key);
  Surface& surface = found->second;
  if (surface.triangles)
    return answer(part_of(surface.triangles->vertices, surface.triangles->triangles, request));
  try {
    surface.waiting.emplace_back(request, std::move(answer));
    if (is_new) make(key, grid->field);
  } catch (...) {
    if (is_new) grids_.erase(found);
    throw;
  }
}

void ShapeParts::forget_others(std::size_t scene, std::uint32_t version) {
  std::erase_if(grids_, [&](const auto& kept) {
    const auto& [key, surface] = kept;
    return key.scene == scene && key.version != version && surface.triangles.has_value();
  });
}

/// Makes the triangles of a grid in the other thread. enter() then takes them in this one.
void ShapeParts::make(const Key& key, std::shared_ptr<const DistanceGrid<float>> field) {
  if (!worker_) {
    worker_.emplace(1);
    asio::post(*worker_, [] { give_way(); });
  }
  asio::post(*worker_, [this, key, field = std::move(field)] {
    const auto made = std::make_shared<std::optional<TriangleSoup>>();
    try {
      *made = isosurface(*field, kGridSteps);
    } catch (const std::exception& error) {
      spdlog::error("the triangles of a grid were not made: {}", error.what());
    }
    post_patiently(post_to(io_), [this, key, made] { enter(key, std::move(*made)); });
  });
}

/// Answers the requests that wait for these triangles. Empty: they could not be made.
void ShapeParts::enter(const Key& key, std::optional<TriangleSoup> made) {
  const auto found = grids_.find(key);
  const auto waiting = std::exchange(found->second.waiting, {});
  found->second.triangles = std::move(made);
  const auto& triangles = found->second.triangles;
  for (const auto& [request, answer] : waiting) {
    if (triangles)
      answer(part_of(triangles->vertices, triangles->triangles, request));
    else
      answer(Refused{RefusalCode::failed, "the server has no memory for the shape's triangles"});
  }
  if (!triangles) grids_.erase(found);
}

}  // namespace feltwire
