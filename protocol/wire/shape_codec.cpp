#include "protocol/wire/shape_codec.hpp"

#include <vector>

#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control_values.hpp"

namespace feltwire::control {
namespace {

flatbuffers::Offset<wire::ShapeDescription> description(flatbuffers::FlatBufferBuilder& builder,
                                                        const ShapeDescription& shape) {
  const wire::Vector position = wire_vector(shape.pose.position);
  const wire::Turn orientation = wire_turn(shape.pose.orientation);
  const auto name = builder.CreateString(shape.name), kind = builder.CreateString(shape.shape);
  const auto lengths = builder.CreateVector(shape.lengths);
  const auto material = name_if_any(builder, shape.material);
  const auto action = name_if_any(builder, shape.action);
  return wire::CreateShapeDescription(builder, name, kind, lengths, &position, &orientation,
                                      shape.parts, shape.moves, shape.from_inside, material, action,
                                      shape.closed);
}

bool read(const wire::ShapeDescription& from, ShapeDescription& to) {
  if (from.lengths()->size() > kMaxLengths || !aligned(*from.lengths(), alignof(double)))
    return false;
  to.lengths.assign(from.lengths()->begin(), from.lengths()->end());
  to.pose = {vector(*from.position()), turn(*from.orientation())};
  to.parts = from.parts();
  to.moves = from.moves();
  to.from_inside = from.from_inside();
  to.closed = from.closed();
  return read_name(from.name(), to.name) && read_name(from.shape(), to.shape) &&
         read_name(from.material(), to.material) && read_name(from.action(), to.action);
}

}  // namespace

flatbuffers::Offset<wire::DescribeShapes> build(flatbuffers::FlatBufferBuilder& builder,
                                                const DescribeShapes& request) {
  return wire::CreateDescribeShapes(builder, builder.CreateString(request.scene),
                                    wire_enum<wire::ShapeGroup>(request.group), request.from);
}

flatbuffers::Offset<wire::ShapeDescriptions> build(flatbuffers::FlatBufferBuilder& builder,
                                                   const ShapeDescriptions& list) {
  std::vector<flatbuffers::Offset<wire::ShapeDescription>> entries;
  for (const ShapeDescription& shape : list.shapes) entries.push_back(description(builder, shape));
  const auto shapes = builder.CreateVector(entries);
  const auto scene = name_if_any(builder, shortened(list.scene, kMaxReason));
  return wire::CreateShapeDescriptions(builder, list.version, scene, list.count, shapes);
}

flatbuffers::Offset<wire::GetShape> build(flatbuffers::FlatBufferBuilder& builder,
                                          const GetShape& request) {
  return wire::CreateGetShape(builder, builder.CreateString(request.scene), request.version,
                              wire_enum<wire::ShapeGroup>(request.group), request.index,
                              request.vertices, request.triangles);
}

flatbuffers::Offset<wire::ShapePart> build(flatbuffers::FlatBufferBuilder& builder,
                                           const ShapePart& part) {
  std::vector<wire::Vector> vertices;
  for (const Vec3& v : part.vertices) vertices.push_back(wire_vector(v));
  std::vector<wire::Corners> triangles;
  for (const Triangle& t : part.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const auto wire_vertices = builder.CreateVectorOfStructs(vertices);
  return wire::CreateShapePart(builder, part.all_vertices, part.all_triangles, wire_vertices,
                               builder.CreateVectorOfStructs(triangles));
}

bool read(const wire::DescribeShapes& from, DescribeShapes& to) {
  to.from = from.from();
  return read_name(from.scene(), to.scene) && read_enum(from.group(), to.group);
}

bool read(const wire::ShapeDescriptions& from, ShapeDescriptions& to) {
  to.version = from.version();
  to.count = from.count();
  if (from.shapes()->size() > kMaxShapes) return false;
  for (const wire::ShapeDescription* shape : *from.shapes())
    if (!read(*shape, to.shapes.emplace_back())) return false;
  return read_name(from.scene(), to.scene, kMaxReason);
}

bool read(const wire::GetShape& from, GetShape& to) {
  to.version = from.version();
  to.index = from.index();
  to.vertices = from.vertices();
  to.triangles = from.triangles();
  return read_name(from.scene(), to.scene) && read_enum(from.group(), to.group);
}

bool read(const wire::ShapePart& from, ShapePart& to) {
  to.all_vertices = from.all_vertices();
  to.all_triangles = from.all_triangles();
  if (from.vertices()->size() > kMaxPart || from.triangles()->size() > kMaxPart) return false;
  if (!aligned(*from.vertices(), alignof(double))) return false;
  for (const wire::Vector* v : *from.vertices()) to.vertices.push_back(vector(*v));
  for (const wire::Corners* t : *from.triangles()) to.triangles.push_back({t->a(), t->b(), t->c()});
  return true;
}

}  // namespace feltwire::control
