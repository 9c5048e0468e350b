#pragma once
// The shapes that the contact of an extreme is judged on, each with a place of its surface where
// the contact has a closed form.

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"
#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

inline constexpr std::array kExtremeSizes = {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6};  // [m]
inline constexpr std::array kExtremeStiffnesses = {1e-3, 1.0, 1e3, 1e6, 1e9};   // [N/m]
inline constexpr double kFarOrigin = 1e6;  // [m] of an object, on each axis

/// A vector in more digits than the product computes with.
using LongVec3 = Eigen::Matrix<long double, 3, 1>;

/// The signed distance of a point from the part of the surface that it is pressed into [m], and the
/// unit normal there, outwards.
struct SurfaceTruth {
  long double distance = 0.0L;
  LongVec3 normal = LongVec3::UnitZ();
};

struct PressedShape {
  std::string name;  // the column of the table
  Shape shape;
  double size = 1.0;            // [m] the scale of errors
  Vec3 place = Vec3::Zero();    // [m] on the surface, object frame
  Vec3 normal = Vec3::UnitZ();  // unit, outwards
  double thickness = 1.0;       // [m] of the shape behind the place
  bool flat = false;            // a flat face: it holds a tool at any depth
  /// Precondition: the point is near the line through `place` along `normal` [m, object frame].
  std::function<SurfaceTruth(const LongVec3&)> truth;
};

/// Every primitive, a mesh and a grid, with a largest side of about `size` [m].
std::vector<PressedShape> shapes_of_size(double size);
/// Flat shapes of this thickness [m] that are `width` [m] wide.
std::vector<PressedShape> plates(double thickness, double width);
/// Long shapes of this thickness [m] that are `length` [m] long.
std::vector<PressedShape> rods(double thickness, double length);

/// Adds a row with a cell for each shape. `judge` fills in a cell, and throws std::invalid_argument
/// where the scene is refused. `allowed_error`: the largest error of a shape.
template <class Allowed, class Judge>
void add_shape_row(ExtremeMatrix& matrix, const std::string& stress, const std::string& reference,
                   const std::vector<PressedShape>& shapes, const Allowed& allowed_error,
                   const Judge& judge) {
  for (const PressedShape& pressed : shapes) {
    ExtremeCell cell{.stress = stress,
                     .judged = pressed.name,
                     .reference = reference,
                     .allowed = allowed_error(pressed),
                     .assumed_scale = matrix.assumed_scale};
    try {
      judge(pressed, cell);
    } catch (const std::invalid_argument& error) {
      cell.refused = error.what();
    }
    matrix.cells.push_back(std::move(cell));
  }
}

}  // namespace feltwire
