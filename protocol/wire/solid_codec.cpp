#include "protocol/wire/solid_codec.hpp"

#include <string_view>
#include <vector>

#include "core/geometry/shape_lengths.hpp"
#include "core/geometry/shapes.hpp"
#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control_values.hpp"

namespace feltwire::control {
namespace {

constexpr flatbuffers::uoffset_t kInertiaNumbers = 6;
constexpr const char* kMesh = "mesh";

std::vector<double> lengths_of_primitive(const Shape& shape) {
  return on_primitive(
      shape, [](const auto& primitive) { return lengths_of(primitive); },
      [] { return std::vector<double>{}; });
}

const char* name_of(const Shape& shape) {
  return on_primitive(
      shape, [](const auto& primitive) { return primitive.kName; }, [] { return ""; });
}

/// The result of reading a shape from its name and lengths.
struct ReadShape {
  bool known = false;  // true if this program has a shape of this name
  bool whole = false;  // true if the number of lengths is right
  Shape shape = {};
};
ReadShape shape_of(std::string_view name, const flatbuffers::Vector<double>& lengths) {
  ReadShape read;
  Primitives::for_each([&](auto primitive) {
    if (name != primitive.kName) return;
    read.known = true;
    flatbuffers::uoffset_t count = 0;
    primitive.lengths(primitive, [&](const Length&, double& length) {
      if (count < lengths.size()) length = lengths[count];
      ++count;
    });
    read.whole = count == lengths.size();
    read.shape = primitive;
  });
  return read;
}

flatbuffers::Offset<wire::BodyEntry> entry(flatbuffers::FlatBufferBuilder& builder,
                                           const BodyData& body, std::uint32_t points) {
  const ToolCoupling& c = body.coupling;
  const ToolInertia& i = body.inertia;
  const wire::Vector center = wire_vector(i.center), gravity = wire_vector(i.gravity);
  const auto inertia =
      builder.CreateVector(std::vector<double>{i.inertia(0, 0), i.inertia(1, 1), i.inertia(2, 2),
                                               i.inertia(0, 1), i.inertia(0, 2), i.inertia(1, 2)});
  return wire::CreateBodyEntry(builder, points, body.area, body.contact_area, c.stiffness,
                               c.rotational_stiffness, c.max_force, c.max_torque, i.mass, &center,
                               inertia, &gravity, i.damping, i.rotational_damping,
                               wire_enum<wire::ToolIntegration>(i.integration));
}

bool read(const wire::BodyEntry& from, BodyData& to) {
  to.area = from.area();
  to.contact_area = from.contact_area();
  to.coupling = {from.stiffness(), from.rotational_stiffness(), from.max_force(),
                 from.max_torque()};
  ToolInertia& i = to.inertia;
  i.mass = from.mass();
  if (i.mass == 0.0) return true;
  const auto* numbers = from.inertia();
  if (from.center() == nullptr || from.gravity() == nullptr || numbers == nullptr ||
      numbers->size() != kInertiaNumbers)
    return false;
  i.center = vector(*from.center());
  i.gravity = vector(*from.gravity());
  const auto n = [&](flatbuffers::uoffset_t k) { return numbers->Get(k); };
  i.inertia << n(0), n(3), n(4), n(3), n(1), n(5), n(4), n(5), n(2);
  i.damping = from.damping();
  i.rotational_damping = from.rotational_damping();
  return read_enum(from.integration(), i.integration);
}

}  // namespace

flatbuffers::Offset<wire::SolidList> build(flatbuffers::FlatBufferBuilder& builder,
                                           const SolidList& list) {
  std::vector<flatbuffers::Offset<wire::SolidEntry>> entries;
  for (const SolidEntry& listed : list.solids) {
    const SolidData& solid = listed.solid;
    const wire::Vector position = wire_vector(solid.pose.position);
    const wire::Turn orientation = wire_turn(solid.pose.orientation);
    const wire::FeltMaterial material = wire_material(solid.material);
    const bool is_mesh = listed.triangles > 0;
    const auto shape = builder.CreateString(is_mesh ? kMesh : name_of(solid.shape));
    const auto lengths =
        builder.CreateVector(is_mesh ? std::vector<double>{} : lengths_of_primitive(solid.shape));
    entries.push_back(wire::CreateSolidEntry(builder, solid.object, &position, &orientation,
                                             solid.from_inside, &material, shape, lengths,
                                             listed.vertices, listed.triangles));
  }
  const auto solids = builder.CreateVector(entries);
  const auto body =
      list.body ? entry(builder, *list.body, list.points) : flatbuffers::Offset<wire::BodyEntry>{};
  return wire::CreateSolidList(builder, list.version, body, solids);
}

flatbuffers::Offset<wire::BodyPoints> build(flatbuffers::FlatBufferBuilder& builder,
                                            const BodyPoints& part) {
  std::vector<wire::Vector> points;
  for (const Vec3& p : part.points) points.push_back(wire_vector(p));
  return wire::CreateBodyPoints(builder, builder.CreateVectorOfStructs(points));
}

bool read(const wire::SolidList& from, SolidList& to) {
  to.version = from.version();
  if (from.solids()->size() > kMaxSurfaces) return false;
  if (const wire::BodyEntry* body = from.body()) {
    if (!read(*body, to.body.emplace())) return false;
    to.points = body->points();
  }
  for (const wire::SolidEntry* entry : *from.solids()) {
    if (!aligned(*entry->lengths(), alignof(double))) return false;
    const bool is_mesh = entry->shape()->string_view() == kMesh;
    ReadShape read{.known = true, .whole = is_mesh && entry->triangles() > 0};
    if (!is_mesh) read = shape_of(entry->shape()->string_view(), *entry->lengths());
    if (!read.known) continue;
    if (!read.whole) return false;
    to.solids.push_back(
        {.solid = {.object = entry->object(),
                   .shape = read.shape,
                   .mesh = {},
                   .from_inside = entry->from_inside(),
                   .pose = {vector(*entry->position()), turn(*entry->orientation())},
                   .material = material(*entry->material())},
         .vertices = is_mesh ? entry->vertices() : 0,
         .triangles = is_mesh ? entry->triangles() : 0});
  }
  return true;
}

bool read(const wire::BodyPoints& from, BodyPoints& to) {
  if (from.points()->size() > kMaxPart || !aligned(*from.points(), alignof(double))) return false;
  for (const wire::Vector* p : *from.points()) to.points.push_back(vector(*p));
  return true;
}

}  // namespace feltwire::control
