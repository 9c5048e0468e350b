#include "sim/studies/extremes/pressed_shapes.hpp"

#include <cmath>
#include <memory>

#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"

namespace feltwire {
namespace {

using Truth = std::function<SurfaceTruth(const LongVec3&)>;

constexpr double kGridStepsPerSize = 32.0;

/// A plane through `point` with this normal.
Truth flat_truth(const Vec3& point, const Vec3& normal) {
  return [at = LongVec3(point.cast<long double>()),
          out = LongVec3(normal.cast<long double>().normalized())](const LongVec3& p) {
    return SurfaceTruth{out.dot(p - at), out};
  };
}

/// The points at a distance `radius` of the nearest point of a core.
template <class Core>
Truth round_truth(double radius, Core core) {
  return [radius, core](const LongVec3& p) {
    const LongVec3 out = p - core(p);
    const long double length = out.norm();
    return SurfaceTruth{length - static_cast<long double>(radius), out / length};
  };
}

LongVec3 on_axis(const LongVec3& p) { return {0.0L, 0.0L, p.z()}; }

/// The side of a cone, near the half plane through the axis and the point.
Truth cone_truth(const Cone& cone) {
  return [cone](const LongVec3& p) {
    const long double radius = cone.radius, height = 2.0L * cone.half_length;
    const long double slant = std::sqrt(radius * radius + height * height);
    const long double across = std::hypot(p.x(), p.y());
    const LongVec3 outward = LongVec3(p.x(), p.y(), 0.0L) / across;
    const LongVec3 normal = (height * outward + radius * LongVec3::UnitZ()) / slant;
    return SurfaceTruth{
        (across * height + (p.z() - static_cast<long double>(cone.half_length)) * radius) / slant,
        normal};
  };
}

PressedShape sphere(double radius, double size) {
  const Vec3 out = Vec3(1.0, 2.0, 2.0) / 3.0;
  return {.name = "sphere",
          .shape = Sphere{radius},
          .size = size,
          .place = radius * out,
          .normal = out,
          .thickness = 2.0 * radius,
          .truth = round_truth(radius, [](const LongVec3&) { return LongVec3(LongVec3::Zero()); })};
}

PressedShape box(const Vec3& half, int axis, double size) {
  PressedShape pressed{.name = "box",
                       .shape = Box{half},
                       .size = size,
                       .normal = Vec3::Unit(axis),
                       .thickness = 2.0 * half[axis],
                       .flat = true,
                       .truth = {}};
  pressed.place = 0.1 * half;
  pressed.place[axis] = half[axis];
  pressed.truth = flat_truth(pressed.place, pressed.normal);
  return pressed;
}

PressedShape capsule(double radius, double half_length, double size) {
  const Vec3 out(0.6, 0.8, 0.0);
  return {.name = "capsule",
          .shape = Capsule{radius, half_length},
          .size = size,
          .place = radius * out + Vec3(0.0, 0.0, 0.2 * half_length),
          .normal = out,
          .thickness = 2.0 * radius,
          .truth = round_truth(radius, [half_length](const LongVec3& p) {
            const long double end = half_length;
            return LongVec3(0.0L, 0.0L, std::clamp(p.z(), -end, end));
          })};
}

PressedShape cylinder_side(double radius, double half_length, double size) {
  const Vec3 out(0.6, 0.8, 0.0);
  return {.name = "cylinder",
          .shape = Cylinder{radius, half_length},
          .size = size,
          .place = radius * out + Vec3(0.0, 0.0, 0.2 * half_length),
          .normal = out,
          .thickness = 2.0 * radius,
          .truth = round_truth(radius, on_axis)};
}

PressedShape cylinder_end(double radius, double half_length, double size) {
  const Vec3 place(0.1 * radius, 0.05 * radius, half_length);
  return {.name = "cylinder",
          .shape = Cylinder{radius, half_length},
          .size = size,
          .place = place,
          .normal = Vec3::UnitZ(),
          .thickness = 2.0 * half_length,
          .flat = true,
          .truth = flat_truth(place, Vec3::UnitZ())};
}

PressedShape cone_side(double radius, double half_length, double size) {
  const double slant = std::hypot(radius, 2.0 * half_length);
  const Vec3 outward(0.6, 0.8, 0.0);
  return {.name = "cone",
          .shape = Cone{radius, half_length},
          .size = size,
          .place = 0.5 * radius * outward,
          .normal = (2.0 * half_length * outward + radius * Vec3::UnitZ()) / slant,
          .thickness = 0.5 * std::min(radius, 2.0 * half_length),
          .truth = cone_truth(Cone{radius, half_length})};
}

PressedShape cone_base(double radius, double half_length, double size) {
  const Vec3 place(0.1 * radius, 0.05 * radius, -half_length);
  return {.name = "cone",
          .shape = Cone{radius, half_length},
          .size = size,
          .place = place,
          .normal = -Vec3::UnitZ(),
          .thickness = half_length,
          .flat = true,
          .truth = flat_truth(place, -Vec3::UnitZ())};
}

PressedShape torus(double major, double minor, double size) {
  const Vec3 outward(0.6, 0.8, 0.0), out = std::cos(0.5) * outward + std::sin(0.5) * Vec3::UnitZ();
  return {
      .name = "torus",
      .shape = Torus{major, minor},
      .size = size,
      .place = major * outward + minor * out,
      .normal = out,
      .thickness = 2.0 * minor,
      .truth = round_truth(minor, [major](const LongVec3& p) {
        const long double across = std::hypot(p.x(), p.y());
        return LongVec3(LongVec3(p.x(), p.y(), 0.0L) * (static_cast<long double>(major) / across));
      })};
}

PressedShape mesh_of(PressedShape solid) {
  solid.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(tessellate(solid.shape, 16)))};
  solid.name = "mesh";
  return solid;
}

PressedShape grid_of(PressedShape solid) {
  const double step = solid.size / kGridStepsPerSize;
  solid.shape = Grid{std::make_shared<DistanceGrid<float>>(solid_of(solid.shape),
                                                           GridOptions{.resolution = step})};
  solid.name = "grid";
  return solid;
}

}  // namespace

std::vector<PressedShape> shapes_of_size(double size) {
  const PressedShape solid = box(size * Vec3(0.5, 0.4, 0.3), 0, size);
  return {{.name = "plane",
           .shape = Plane{},
           .size = size,
           .place = size * Vec3(0.2, -0.1, 0.0),
           .normal = Vec3::UnitZ(),
           .thickness = size,
           .flat = true,
           .truth = flat_truth(Vec3::Zero(), Vec3::UnitZ())},
          sphere(0.5 * size, size),
          solid,
          capsule(0.2 * size, 0.3 * size, size),
          cylinder_side(0.3 * size, 0.5 * size, size),
          cone_side(0.4 * size, 0.5 * size, size),
          torus(0.35 * size, 0.12 * size, size),
          mesh_of(solid),
          grid_of(solid)};
}

std::vector<PressedShape> plates(double thickness, double width) {
  const PressedShape plate = box(0.5 * Vec3(width, width, thickness), 2, thickness);
  return {plate, cylinder_end(0.5 * width, 0.5 * thickness, thickness),
          cone_base(0.5 * width, 0.5 * thickness, thickness), mesh_of(plate)};
}

std::vector<PressedShape> rods(double thickness, double length) {
  const PressedShape rod = box(0.5 * Vec3(thickness, thickness, length), 0, thickness);
  return {rod,
          capsule(0.5 * thickness, 0.5 * length, thickness),
          cylinder_side(0.5 * thickness, 0.5 * length, thickness),
          cone_side(0.5 * thickness, 0.5 * length, thickness),
          torus(0.5 * length, 0.5 * thickness, thickness),
          mesh_of(rod)};
}

}  // namespace feltwire
