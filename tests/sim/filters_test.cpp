#include "sim/filters.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "client/csv.hpp"

namespace feltwire::filters_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<std::vector<double>> rows(const std::string& csv) {
  std::istringstream in(csv);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> all;
  while (std::getline(in, line)) {
    std::vector<double> row;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) row.push_back(std::stod(field));
    all.push_back(row);
  }
  return all;
}

BoundingConfig contact_frame(double damping) {
  BoundingConfig c;
  c.damping = damping;
  return c;
}

TEST(BoundFilter, RendersTheClosedFormOfASpringBeyondTheLimit) {
  // Pressing in by 0.1 mm a row against 10 kN/m with c = 2 b/T = 1000 N/m: the bound gives c dx a
  // row.
  std::string in = "ex,ey,ez,fx,fy,fz,dx,dy,dz\n";
  for (int n = 1; n <= 5; ++n) in += std::to_string(n) + ",0,0,0,0,0,-1e-4,0,0\n";
  std::istringstream input(in);
  std::ostringstream output;
  EXPECT_EQ(filter_bound(input, output, contact_frame(0.5)), 0u);
  const auto out = rows(output.str());
  ASSERT_EQ(out.size(), 5u);
  double energy = 0.0;
  for (std::size_t n = 0; n < 5; ++n) {
    EXPECT_NEAR(out[n][0], 0.1 * static_cast<double>(n + 1), 1e-12);
    energy += 0.1 * static_cast<double>(n) * -1e-4;  // f(n-1) dx(n), delivered to the hand
    EXPECT_NEAR(out[n][3], energy, 1e-15);
    EXPECT_EQ(out[n][4], 1.0);
  }
}

TEST(BoundFilter, RowsThatAreNotFiniteRenderZero) {
  std::istringstream input(
      "dx,dy,dz,ex,ey,ez,fx,fy,fz\n-1e-3,0,0,0.5,0,0,0,0,0\nnan,0,0,1,0,0,0,0,0\n0,0,0,inf,0,0,0,0,"
      "0\n");
  std::ostringstream output;
  EXPECT_EQ(filter_bound(input, output, contact_frame(1.0)), 2u);
  const auto out = rows(output.str());
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[0][0], 0.5);
  EXPECT_EQ(out[1][0], 0.0);
  EXPECT_EQ(out[2][0], 0.0);
  EXPECT_TRUE(std::isfinite(out[2][3]));
}

TEST(BoundFilter, SaysWhereTheInputIsNoNumber) {
  std::istringstream input("dx,dy,dz,ex,ey,ez,fx,fy,fz\n0,0,0,0,0,0,0,0,0\n0,0,0,oops,0,0,0,0,0\n");
  std::ostringstream output;
  EXPECT_THAT([&] { filter_bound(input, output, contact_frame(1.0)); },
              ThrowsMessage<CsvError>(
                  testing::AllOf(HasSubstr("stdin:3"), HasSubstr("ex"), HasSubstr("oops"))));
  EXPECT_EQ(rows(output.str()).size(), 1u) << "what was good before it is not lost";
}

Scene floor_scene() {
  return parse_scene(R"({"name": "floor",
    "materials": [{"name": "m", "stiffness": 500, "viscous_friction": 2}],
    "objects": [{"name": "floor", "plane": {}, "material": "m"}]})",
                     "floor.json");
}

TEST(TouchFilter, GivesStiffnessTimesDepthAndViscousFriction) {
  std::istringstream input(
      "t,x,y,z\n0,0,0,0.001\n0.01,0.002,0,-0.002\n0.02,0.004,0,-0.002\n0.03,0.004,0,0.001\n");
  std::ostringstream output;
  const Scene scene = floor_scene();
  EXPECT_EQ(filter_touch(input, output, scene), 0u);
  const auto out = rows(output.str());
  ASSERT_EQ(out.size(), 4u);
  EXPECT_EQ(out[0], std::vector<double>(6, 0.0));
  for (const std::size_t n : {1u, 2u}) {
    EXPECT_NEAR(out[n][2], 1.0, 1e-12);
    EXPECT_NEAR(out[n][3], -2.0 * 0.2, 1e-12) << "2 N s/m at 0.2 m/s";
  }
  EXPECT_EQ(out[3], std::vector<double>(6, 0.0));
}

TEST(TouchFilter, RefusesTimeThatStandsStill) {
  std::istringstream input("t,x,y,z\n0,0,0,0\n0,0,0,0\n");
  std::ostringstream output;
  const Scene scene = floor_scene();
  EXPECT_THAT([&] { filter_touch(input, output, scene); },
              ThrowsMessage<CsvError>(HasSubstr("stdin:3")));
}

}  // namespace
}  // namespace feltwire::filters_test
