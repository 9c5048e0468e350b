#include "sim/lab/filters.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "core/base/csv.hpp"
#include "core/scene_file/load_scene.hpp"

namespace feltwire::filters_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

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
  // The hand presses in by 0.1 mm per row against 10 kN/m. With c = 2 b/T = 1000 N/m, the bound
  // must give c dx per row.
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

/// A motor that is late by one period gives the energy of the force before.
TEST(BoundFilter, TheEnergyOfTheTrueMotorIsThatBehindItsAmplifier) {
  std::string in = "ex,ey,ez,fx,fy,fz,dx,dy,dz\n";
  for (int n = 1; n <= 5; ++n) in += std::to_string(n) + ",0,0,0,0,0,-1e-4,0,0\n";
  const BoundingConfig config = contact_frame(0.5);
  for (const double delay : {0.0, config.period}) {
    std::istringstream input(in);
    std::ostringstream output;
    filter_bound(input, output, config, {}, Plant::Amplifier{.delay = delay});
    EXPECT_THAT(output.str(), ::testing::StartsWith("rx,ry,rz,energy,active,motor\n"));
    const auto out = rows(output.str());
    ASSERT_EQ(out.size(), 5u);
    double energy = 0.0;
    const std::size_t late = delay > 0.0 ? 2 : 1;
    for (std::size_t n = 0; n < 5; ++n) {
      if (n >= late) energy += out[n - late][0] * -1e-4;
      EXPECT_NEAR(out[n][5], energy, 1e-12) << n << ' ' << delay;
    }
  }
}

TEST(BoundFilter, WithRotationATorqueIsBoundedAndItsEnergyCounted) {
  // The hand rotates by 1 mrad per row against 10 N m/rad. With c_r = 2 b_r/T = 1 N m/rad, the
  // bound must give c_r dtheta per row.
  std::string in = "dx,dy,dz,ex,ey,ez,fx,fy,fz,ax,ay,az,tx,ty,tz\n";
  for (int n = 1; n <= 4; ++n)
    in += "0,0,0,0,0,0,0,0,0,0,-1e-3,0,0," + std::to_string(0.01 * n) + ",0\n";
  BoundingConfig config = contact_frame(0.5);
  config.rotation = true;
  config.rotational_damping = 5e-4;
  std::istringstream input(in);
  std::ostringstream output;
  EXPECT_EQ(filter_bound(input, output, config), 0u);
  EXPECT_THAT(output.str(), ::testing::StartsWith("rx,ry,rz,rtx,rty,rtz,energy,active\n"));
  const auto out = rows(output.str());
  ASSERT_EQ(out.size(), 4u);
  double energy = 0.0;
  for (std::size_t n = 0; n < out.size(); ++n) {
    EXPECT_NEAR(out[n][4], 1e-3 * static_cast<double>(n + 1), 1e-12);
    energy += 1e-3 * static_cast<double>(n) * -1e-3;
    EXPECT_NEAR(out[n][6], energy, 1e-15);
  }
  std::istringstream missing("dx,dy,dz,ex,ey,ez,fx,fy,fz\n");
  EXPECT_THROW(filter_bound(missing, output, config), CsvError);
}

/// A force of 0.5 N acts along a movement of 1 mm. The account gets 0.5 N s/m (1e-3 m)^2/T = 0.5 mJ
/// and needs 0.5 mJ. No energy remains for the next force.
TEST(BoundFilter, AnAccountStandsAfterTheMethod) {
  std::istringstream input(
      "dx,dy,dz,ex,ey,ez,fx,fy,fz\n0,0,0,0,0,0,0,0,0\n1e-3,0,0,0.5,0,0,0,0,0\n");
  std::ostringstream output;
  BoundingConfig config = contact_frame(0.5);
  config.mode = kUnbounded;
  AccountConfig account;
  account.translation.damping = 0.5;
  account.translation.mass = 0.1;
  account.translation.outside_force = 10.0;
  EXPECT_EQ(filter_bound(input, output, config, account), 0u);
  EXPECT_THAT(output.str(), ::testing::StartsWith("rx,ry,rz,energy,active,balance\n"));
  const auto out = rows(output.str());
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0][5], 0.0);
  EXPECT_NEAR(out[1][5], 0.5 * 1e-6 / config.period, 1e-15);
  PortAccount same(account);
  BoundingStep step;
  step.hold_time = config.period;
  same.step(step);
  step.displacement.x() = 1e-3;
  step.command.elastic.x() = 0.5;
  EXPECT_EQ(out[1][0], same.step(step).elastic.x());
}

/// Over an equal distance, a hold of 2 T dissipates half as much. Each row has the normals of its
/// walls, and states whether its command is local.
TEST(BoundFilter, ARowHasItsHoldAndItsWalls) {
  std::istringstream input(
      "dx,dy,dz,ex,ey,ez,fx,fy,fz,hold,local,n1x,n1y,n1z\n"
      "0,0,0,0,0,0,0,0,0,1e-3,0,0,0,0\n1e-3,0,0,0,0,0,0,0,0,2e-3,1,0,0,2\n");
  std::ostringstream output;
  AccountConfig account;
  account.translation.damping = 0.5;
  filter_bound(input, output, contact_frame(0.5), account);
  EXPECT_NEAR(rows(output.str())[1][5], 0.5 * 1e-6 / 2e-3, 1e-15);
  const auto error = [](const std::string& columns, const std::string& row) {
    std::istringstream in("dx,dy,dz,ex,ey,ez,fx,fy,fz," + columns + "\n0,0,0,0,0,0,0,0,0," + row +
                          "\n");
    std::ostringstream none;
    try {
      filter_bound(in, none, contact_frame(0.5));
    } catch (const CsvError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(error("hold", "0"), HasSubstr("stdin:2: column 'hold'"));
  EXPECT_THAT(error("hold", "nan"), HasSubstr("stdin:2: column 'hold'"));
  EXPECT_THAT(error("local", "2"), HasSubstr("stdin:2: column 'local'"));
  EXPECT_THAT(error("n1x,n1y", "0,1"), HasSubstr("n1x,n1y,n1z"));
  EXPECT_THAT(error("n2x,n2y,n2z", "0,inf,0"), HasSubstr("stdin:2: column 'n2x'"));
  EXPECT_EQ(error("n2x,n2y,n2z", "0,1,0"), "");
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
                  ::testing::AllOf(HasSubstr("stdin:3"), HasSubstr("ex"), HasSubstr("oops"))));
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

Scene tools_scene() {
  return parse_scene(R"({"name": "bench",
    "materials": [{"name": "m", "stiffness": 500}],
    "objects": [{"name": "floor", "plane": {}, "material": "m"}],
    "tools": [{"name": "tip"}, {"name": "ball", "sphere": {"radius": 0.01}},
              {"name": "bar", "body": {"box": {"size": [0.08, 0.01, 0.02]}, "points": 2000}}]})",
                     "bench.json");
}

TEST(TouchFilter, AnswersTheToolThatIsNamed) {
  const Scene scene = tools_scene();
  const auto answer = [&](const std::string& tool) {
    std::istringstream input("t,x,y,z\n0,0,0,0.02\n0.01,0,0,0.006\n");
    std::ostringstream output;
    EXPECT_EQ(filter_touch(input, output, scene, tool), 0u);
    return rows(output.str()).back();
  };
  EXPECT_EQ(answer(""), std::vector<double>(6, 0.0));
  EXPECT_EQ(answer("tip"), std::vector<double>(6, 0.0));
  EXPECT_NEAR(answer("ball")[2], 2.0, 1e-9);
  EXPECT_THAT([&] { answer("hammer"); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("no tool 'hammer'; the existing ones are: tip, ball, bar")));
}

TEST(TouchFilter, ABodyIsTurnedAndAnswersWithATorque) {
  for (const bool moving : {false, true}) {
    const Scene scene = moving ? parse_scene(R"({"name": "bench", "gravity": [0, 0, 0],
    "materials": [{"name": "m", "stiffness": 500}],
    "objects": [{"name": "floor", "plane": {}, "material": "m"},
                {"name": "far", "sphere": {"radius": 0.1}, "material": "m", "body": "b"}],
    "bodies": [{"name": "b", "mass": 1, "position": [5, 0, 5]}],
    "tool": {"body": {"box": {"size": [0.08, 0.01, 0.02]}, "points": 2000}}})",
                                             "bench.json")
                               : tools_scene();
    // The tool moves in by 2 mm slowly from above, rotated by an angle about y.
    const auto pressed = [&](double angle) {
      const double reach = 0.04 * std::abs(std::sin(angle)) + 0.01 * std::abs(std::cos(angle));
      std::string csv = "t,x,y,z,qw,qx,qy,qz\n";
      for (int n = 0; n <= 200; ++n)
        csv += std::to_string(0.001 * n) + ",0,0," + std::to_string(reach + 0.018 - 0.0001 * n) +
               "," + std::to_string(3 * std::cos(angle / 2)) + ",0," +
               std::to_string(3 * std::sin(angle / 2)) + ",0\n";
      std::istringstream input(csv + "nan,0,0,0,1,0,0,0\n");
      std::ostringstream output;
      EXPECT_EQ(filter_touch(input, output, scene, moving ? "" : "bar"), 1u);
      EXPECT_EQ(output.str().substr(0, 27), "ex,ey,ez,fx,fy,fz,tx,ty,tz\n");
      const auto out = rows(output.str());
      EXPECT_EQ(out.size(), 202u);
      for (const double free : out[0]) EXPECT_NEAR(free, 0.0, 1e-12);
      EXPECT_EQ(out[201], std::vector<double>(9, 0.0));
      return out[200];
    };
    const auto flat = pressed(0.0), turned = pressed(0.3), back = pressed(-0.3);
    EXPECT_GT(flat[2], 0.2);
    EXPECT_LT(std::abs(flat[7]), 0.002 * flat[2]);  // for a lever of 40 mm
    // After a rotation about y, the low end is at +x. The force up at this end is a torque about
    // -y.
    EXPECT_GT(turned[2], 0.01);
    EXPECT_LT(turned[7], -0.015 * turned[2]);
    EXPECT_GT(back[7], 0.015 * back[2]);
  }
}

TEST(TouchFilter, ABodyNeedsAnOrientation) {
  const Scene scene = tools_scene();
  const auto error = [&](const std::string& csv) {
    std::istringstream input(csv);
    std::ostringstream output;
    try {
      filter_touch(input, output, scene, "bar");
    } catch (const CsvError& wrong) {
      return std::string(wrong.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error("t,x,y,z\n0,0,0,0\n"), HasSubstr("qw"));
  EXPECT_THAT(error("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n"), HasSubstr("are no rotation"));
}

}  // namespace
}  // namespace feltwire::filters_test
