// Compares the cells of a polyhedron with cells that are cut out separately.

#include "core/polyhedra/closest_face_cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/polyhedra/polyhedron.hpp"
#include "tests/core/polyhedra/solids.hpp"

namespace feltwire::closest_face_cells_test {
namespace {

using test::box_corners;
using test::placed;
using test::random_solid;
using Tag = ClosestFaceCells::Tag;

/// f(x) = offset - normal . x
struct Linear {
  Vec3 normal;
  double offset;
  double at(const Vec3& x) const { return offset - normal.dot(x); }
};

ClosestFaceCells cells_of(const ClippedPolyhedron& whole, const std::vector<Linear>& functions) {
  ClosestFaceCells cells(whole, functions[0].normal, functions[0].offset, 0);
  for (std::size_t k = 1; k < functions.size(); ++k)
    cells.insert(functions[k].normal, functions[k].offset, k);
  return cells;
}

/// Computes six times the signed volume of tetrahedra between triangles and the origin. Each face
/// is a fan of triangles from its first corner.
class Volume {
 public:
  explicit Volume(const Vec3& from) : from_(from) {}
  void add(Tag face, const Vec3& a, const Vec3& b) {
    const Vec3& first = first_.try_emplace(face, a).first->second;
    six_ += (first - from_).dot((a - from_).cross(b - from_));
  }
  double value() const { return six_ / 6.0; }

 private:
  Vec3 from_;
  std::map<Tag, Vec3> first_;
  double six_ = 0.0;
};

double volume(const ClippedPolyhedron& solid) {
  if (solid.empty()) return 0.0;
  Volume sum(solid.corner(0));
  for (std::size_t i = 0; i < solid.corner_count(); ++i)
    for (std::size_t s = 0; s < 3; ++s)
      sum.add(solid.tags(i)[s], solid.corner(i),
              solid.corner(solid.neighbour(i, (s + 1) % 3).corner));
  return sum.value();
}

double volume(const ClosestFaceCells& cells, std::size_t cell) {
  Volume sum(Vec3::Zero());
  for (std::size_t i = 0; i < cells.corner_count(); ++i)
    for (std::size_t slot = 0; slot < 4; ++slot) {
      if (cells.faces(i)[slot] != ClosestFaceCells::kCell + cell) continue;
      const auto& way = cells.around(i, slot);
      for (std::size_t k = 0; k < 3; ++k)
        sum.add(cells.faces(i)[way[k]], cells.corner(i),
                cells.corner(cells.beyond(i, way[(k + 2) % 3])));
    }
  return sum.value();
}

/// Checks that the stored value at each corner is the least of all functions. The functions of its
/// cells must give this value.
void expect_least(const ClosestFaceCells& cells, const std::vector<Linear>& functions,
                  double slack) {
  for (std::size_t i = 0; i < cells.corner_count(); ++i) {
    const Vec3 x = cells.corner(i);
    for (const Linear& f : functions) EXPECT_LE(cells.least(i), f.at(x) + slack);
    for (const Tag tag : cells.faces(i)) {
      const std::size_t cell = std::size_t{tag} - ClosestFaceCells::kCell;
      if (cell < functions.size()) {
        EXPECT_NEAR(functions[cell].at(x), cells.least(i), slack);
      }
    }
  }
}

/// Compares each cell with a separate cut of the complete polyhedron.
void expect_as_cut(const ClippedPolyhedron& whole, const std::vector<Linear>& functions) {
  const ClosestFaceCells cells = cells_of(whole, functions);
  expect_least(cells, functions, 1e-13);
  const double all = volume(whole);
  double sum = 0.0;
  for (std::size_t k = 0; k < functions.size(); ++k) {
    ClippedPolyhedron alone(whole);
    Tag tag = 100;
    for (const Linear& other : functions)
      if (&other != &functions[k] &&
          !alone.cut(other.normal - functions[k].normal, other.offset - functions[k].offset, tag++))
        break;
    EXPECT_NEAR(volume(cells, k), volume(alone), 1e-10 * all) << k;
    sum += volume(cells, k);
  }
  EXPECT_NEAR(sum, all, 1e-10 * all);
}

std::vector<Linear> random_functions(test::Random& random, int count) {
  std::vector<Linear> functions;
  for (int k = 0; k < count; ++k)
    functions.push_back({random.direction(), random.uniform(0.0, 0.02)});
  return functions;
}

TEST(ClosestFaceCells, AreThoseThatAreCutOutOneByOne) {
  test::Random random(11);
  for (int i = 0; i < 60; ++i) {
    ClippedPolyhedron whole = placed(random_solid(random, 0.05));
    for (Tag tag = 0; tag < i % 5; ++tag) whole.cut(random.direction(), 0.02, tag);
    expect_as_cut(whole, random_functions(random, 1 + i));
  }
}

TEST(ClosestFaceCells, OneFunctionIsLeastEverywhere) {
  const ClippedPolyhedron whole = placed(polyhedron(box_corners(Vec3::Constant(0.01))));
  const std::vector<Linear> functions = {{Vec3::UnitX(), 0.5}, {Vec3::UnitY(), 0.2}};
  const ClosestFaceCells cells = cells_of(whole, functions);
  expect_least(cells, functions, 1e-15);
  EXPECT_EQ(volume(cells, 0), 0.0);  // The second cell must contain everything.
  EXPECT_NEAR(volume(cells, 1), 8e-6, 1e-18);
  EXPECT_EQ(cells.corner_count(), 8u);
}

/// The functions are the planes of the faces. Six pyramids meet in the middle, and only rounding
/// decides.
TEST(ClosestFaceCells, SixPyramidsOfACubeMeetInItsMiddle) {
  for (const double size : {1e-4, 0.01, 3.0}) {
    const ClippedPolyhedron whole = placed(polyhedron(box_corners(Vec3::Constant(size))));
    std::vector<Linear> functions;
    for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
      for (const double side : {-1.0, 1.0}) functions.push_back({side * way, size});
    functions.push_back(functions[2]);  // This function appears twice.
    const ClosestFaceCells cells = cells_of(whole, functions);
    expect_least(cells, functions, 1e-13);
    for (std::size_t k = 0; k < 6; ++k)
      EXPECT_NEAR(volume(cells, k), 8.0 / 6.0 * std::pow(size, 3), 1e-12 * std::pow(size, 3)) << k;
    EXPECT_NEAR(volume(cells, 6), 0.0, 1e-12 * std::pow(size, 3));
  }
}

/// These functions vanish at corners and along edges of the polyhedron.
TEST(ClosestFaceCells, FunctionsThatTouchLeaveItClosed) {
  test::Random random(12);
  for (int i = 0; i < 200; ++i) {
    const ClippedPolyhedron whole = placed(polyhedron(box_corners(Vec3::Constant(0.01))));
    std::vector<Linear> functions = {{Vec3::UnitZ(), 0.01}};
    for (int k = 0; k < 8; ++k) {
      const auto coordinate = [&] { return std::floor(random.uniform(-1.0, 2.0)); };
      const Vec3 normal(coordinate(), coordinate(), coordinate());
      const Vec3 through = 0.01 * Vec3(coordinate(), coordinate(), coordinate());
      const Linear next{normal, 0.01 - through.z() + normal.dot(through)};
      const auto same = [&](const Linear& f) {
        return f.normal == next.normal && std::abs(f.offset - next.offset) < 1e-12;
      };
      if (std::ranges::none_of(functions, same)) functions.push_back(next);
    }
    expect_as_cut(whole, functions);
  }
}

}  // namespace
}  // namespace feltwire::closest_face_cells_test
