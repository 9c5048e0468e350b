// Makes the message that describes a scene: its objects, guides, tools and seats.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "core/tool/body_tool.hpp"
#include "server/access/json_text.hpp"
#include "server/web/object_triangles.hpp"
#include "server/web/page_messages.hpp"
#include "server/web/value_texts.hpp"

namespace feltwire::web {
namespace {

using json_text::number;
using json_text::text;

/// The bounding box of all points that were passed to add().
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

Vec3 in_world(const Pose& pose, const Vec3& point) {
  return pose.position + pose.orientation * point;
}

std::string object_text(const Object& object, std::size_t index, bool moves) {
  std::vector<json_text::Member> members = {
      {"index", number(std::uint64_t{index})},
      {"name", text(object.name)},
      {"moves", flag_text(moves)},
      {"stiffness", number(object.material.stiffness)},
      {"felt_from", text(object.felt_from == Side::outside ? "outside" : "inside")}};
  if (std::holds_alternative<Plane>(object.shape))
    members.emplace_back(
        "plane",
        json_text::object({{"point", vector_text(object.pose.position)},
                           {"normal", vector_text(object.pose.orientation * Vec3::UnitZ())}}));
  return json_text::object(members);
}

const char* kind_of(const GuideAction& action) {
  constexpr std::array<const char*, 5> kKinds = {"attract", "keep_out", "magnet", "viscosity",
                                                 "constant_force"};
  return kKinds[action.index()];
}

double micrometres(double value) { return std::round(1e6 * value) * 1e-6; }

/// Returns the triangles of the place of a guide in the world frame. Empty if the place is no
/// shape.
TriangleSoup solid_of(const Guide& guide, const Vec3& start) {
  const Pose pose =
      std::holds_alternative<Plane>(guide.place) ? square_pose(guide.pose, start) : guide.pose;
  TriangleSoup soup = triangles_of_place(guide.place);
  for (Vec3& vertex : soup.vertices) vertex = in_world(pose, vertex).unaryExpr(&micrometres);
  return soup;
}

/// Returns a guide as JSON. A guide without a place has no points and no triangles.
std::string guide_text(const Guide& guide, const TriangleSoup& solid) {
  std::vector<Vec3> points;
  bool closed = false;
  if (std::holds_alternative<GuidePoint>(guide.place)) {
    points = {Vec3::Zero()};
  } else if (const auto* line = std::get_if<GuideLine>(&guide.place)) {
    constexpr double kFarthest = 1.0;  // [m] largest half length that is shown
    const Vec3 end(0.0, 0.0, std::min(line->half_length, kFarthest));
    points = {-end, end};
  } else if (const auto* curve = std::get_if<GuideCurve>(&guide.place)) {
    points = curve->points;
    closed = curve->closed;
  }
  std::vector<std::string> places;
  places.reserve(points.size());
  for (const Vec3& point : points) places.push_back(vector_text(in_world(guide.pose, point)));
  std::vector<std::string> vertices, triangles;
  for (const Vec3& vertex : solid.vertices) vertices.push_back(vector_text(vertex));
  for (const auto& [a, b, c] : solid.triangles)
    triangles.push_back(json_text::list(
        {number(std::uint64_t{a}), number(std::uint64_t{b}), number(std::uint64_t{c})}));
  return json_text::object({{"name", text(guide.name)},
                            {"kind", text(kind_of(guide.action))},
                            {"closed", flag_text(closed)},
                            {"points", json_text::list(places)},
                            {"vertices", json_text::list(vertices)},
                            {"triangles", json_text::list(triangles)}});
}

/// Returns a tool as JSON. A tool with a body has many surface points: at most kMostPoints are
/// sent, which is enough to draw the tool.
std::string tool_text(const HandTool& tool) {
  constexpr std::size_t kMostPoints = 400;
  std::vector<std::string> points;
  if (tool.body) {
    const std::vector<Vec3>& shell = tool.body->shell().points;
    const std::size_t step = (shell.size() + kMostPoints - 1) / kMostPoints;
    for (std::size_t i = 0; i < shell.size(); i += step) points.push_back(vector_text(shell[i]));
  }
  return json_text::object({{"name", text(tool.name)},
                            {"radius", number(tool.radius)},
                            {"points", json_text::list(points)}});
}

}  // namespace

std::string scene_text(const Scene& scene, std::uint32_t version) {
  const std::vector<Object>& objects = scene.objects();
  const std::size_t still = scene.views().front().still();
  std::vector<std::string> entries, guides, tools, seats;
  Box box;
  box.add(scene.start().position);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Object& object = objects[i];
    entries.push_back(object_text(object, i, i >= still));
    const TriangleSoup soup = triangles_of(object.shape);
    for (const Vec3& vertex : soup.vertices) box.add(in_world(object.pose, vertex));
    if (std::holds_alternative<Plane>(object.shape)) {
      const Pose seen = square_pose(object.pose, scene.start().position);
      for (const Vec3& corner : plane_square().vertices) box.add(in_world(seen, corner));
    }
  }
  for (const Guide& guide : scene.guides()) {
    const TriangleSoup solid = solid_of(guide, scene.start().position);
    for (const Vec3& vertex : solid.vertices) box.add(vertex);
    guides.push_back(guide_text(guide, solid));
  }
  for (const ToolView& view : scene.views()) tools.push_back(tool_text(view.tool()));
  for (const RemoteSeat& seat : scene.seats()) seats.push_back(text(seat.name));
  return json_text::object(
      {{"type", text("scene")},
       {"name", text(scene.name())},
       {"version", number(std::uint64_t{version})},
       {"objects", json_text::list(entries)},
       {"guides", json_text::list(guides)},
       {"tools", json_text::list(tools)},
       {"seats", json_text::list(seats)},
       {"box", "[" + vector_text(box.low) + "," + vector_text(box.high) + "]"}});
}

}  // namespace feltwire::web
