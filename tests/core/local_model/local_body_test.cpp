// Compares the local model of a tool with a body with closed forms and with its scene.

#include "core/local_model/local_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/local_model_extraction/body_points.hpp"
#include "tests/core/bodies.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::local_body_test {
namespace {

using test::kFace;
using test::kHalf;
using test::kStiffness;
using test::object;

/// A box as the tool, and a surface that it touches.
struct HeldBox {
  explicit HeldBox(const Shape& shape, double friction = 0.0, const Vec3& at = Vec3::Zero(),
                   std::size_t points = 2000) {
    Object o = object(shape, at);
    o.material.static_friction = friction;
    o.material.dynamic_friction = 0.75 * friction;
    std::vector<Object> objects = {o};
    scene.emplace("held", std::move(objects));
    scene->set_tool({.body = std::make_shared<BodyTool>(test::tool(points))});
  }
  Command touch(const Pose& device) { return scene->touch(device, Vec3::Zero(), 1e-3, memory); }
  BodyModel model(const Pose& device) const { return body_model(*scene, device, memory); }
  /// Steps until the tool rests. Returns the command.
  Command settle(const Pose& device) {
    Command c;
    for (int i = 0; i < 50; ++i) c = touch(device);
    return c;
  }

  std::optional<Scene> scene;
  BodyMemory memory;
};

Pose leaning(double above, double angle, const Vec3& about) {
  return {Vec3(0, 0, above), Quaternion(Eigen::AngleAxisd(angle, about.normalized()))};
}

ShellContact contact(const BodyModel& model, const Pose& tool) {
  return ModelledSurroundings(model, 0.0, 1e-3).contact(tool);
}

TEST(LocalBody, SaysNothingOfAToolThatIsAPointOrFarAway) {
  HeldBox held(Plane{});
  EXPECT_EQ(held.model({}).reach, 0.0);  // not placed yet
  const Pose far{Vec3(0, 0, 1), Quaternion::Identity()};
  held.touch(far);
  const BodyModel model = held.model(far);
  EXPECT_EQ(model.count, 0);
  EXPECT_EQ(model.reach, kBodyReach);
  const Scene point("point", {object(Plane{})});
  EXPECT_EQ(body_model(point, far, held.memory).reach, 0.0);
}

// A box flat on a plane gets k / A_c times area times depth. A tilted box gets the moment of an
// elastic foundation: k / A_c I angle.
TEST(LocalBody, ABoxFlatOnAPlane) {
  HeldBox held(Plane{}, 0.0, Vec3::Zero(), 20000);
  const Pose device = leaning(0.009, 0.0, Vec3::UnitX());
  held.settle(device);
  const BodyModel model = held.model(device);
  ASSERT_GT(model.count, 10);
  const double bed = kStiffness / kFace;  // [N/m^3] stiffness per area of the foundation
  for (const double further : {0.0, 1e-4, 3e-4}) {
    Pose tool = held.memory.pose;
    tool.position.z() -= further;
    const double depth = 0.01 - tool.position.z();
    const ShellContact c = contact(model, tool);
    EXPECT_NEAR(c.wrench[2], test::flat_force(depth, kFace), 0.01 * c.wrench[2] + 0.003) << further;
    EXPECT_LT(c.wrench.tail<3>().norm(), 3e-4);
  }
  const double angle = 2e-3;  // Every spring stays compressed.
  for (const auto& [about, moment] :
       {std::pair(Vec3(Vec3::UnitX()), 0.06 * std::pow(0.04, 3) / 12.0),
        std::pair(Vec3(Vec3::UnitY()), 0.04 * std::pow(0.06, 3) / 12.0)}) {
    const ShellContact flat = contact(model, held.memory.pose);
    const ShellContact c = contact(model, moved(held.memory.pose, Vec3::Zero(), angle * about));
    const double turned_back = -(c.wrench - flat.wrench).tail<3>().dot(about);
    EXPECT_NEAR(turned_back, bed * moment * angle, 0.1 * bed * moment * angle) << about.transpose();
  }
}

// At its own pose the model must give the scene's wrench for every touched surface.
TEST(LocalBody, AtItsPoseIsTheScene) {
  for (const double angle : {0.0, 0.05, 0.2, 0.6, 0.955}) {
    for (const Vec3& about : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(2, 3, 0)}) {
      HeldBox held(Plane{}, 0.4);
      const Pose device = leaning(angle < 0.3 ? 0.009 : 0.02, angle, about);
      held.settle(device);
      const BodyModel model = held.model(device);
      if (held.memory.contact.touching == 0) continue;
      const ShellContact c = contact(model, held.memory.pose);
      EXPECT_LT((c.wrench - held.memory.contact.wrench).norm(),
                1e-9 * held.memory.contact.wrench.norm())
          << angle << " about " << about.transpose();
      ASSERT_EQ(c.grip_count, held.memory.contact.grip_count);
      EXPECT_NEAR(c.patches[0].load, held.memory.contact.patches[0].load, 1e-9);
    }
  }
}

// A model with all points of a corner must equal the scene even after the tool has moved.
TEST(LocalBody, ACornerIsTheSceneAlsoElsewhere) {
  HeldBox held(Plane{});
  Pose device = leaning(0.0, 0.9, Vec3(-2, 3, 0));
  const Mat3 turned = device.orientation.toRotationMatrix();
  double low = 0.0;  // [m] height of the tool's origin above the lowest corner
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      low = std::min(low, (turned * kHalf.cwiseProduct(Vec3(x, y, -1))).z());
  device.position.z() = -low - 0.004;
  held.settle(device);
  ASSERT_GT(held.memory.contact.touching, 0u);

  const BodyModel model = held.model(device);
  for (const double further : {-1e-4, 0.0, 1e-4, 2e-4}) {
    const Pose tool = moved(held.memory.pose, Vec3(1e-3, 0, -further), Vec3(0, 0, further));
    ShellContact there;
    add_contact(held.scene->tool().body->shell(), tool, held.scene->objects()[0],
                held.scene->tool().body->contact_area(), there);
    const ShellContact c = contact(model, tool);
    EXPECT_LT((c.wrench - there.wrench).norm(), 0.1 * there.wrench.norm()) << further;
  }
}

BodyModel random_model(test::Random& random, double scale) {
  BodyModel model;
  model.tool.position = 0.01 * random.direction();
  model.reach = model.turn = 0.03;
  model.coupling = {1000.0, 1.0, 8.0, 0.3};
  model.radius = 0.03;
  model.count = kMaxBodyPoints;
  model.patch_count = kMaxBodyPatches;
  for (BodyPoint& point : model.points) {
    const Vec3 wide = 0.01 * random.direction();
    point = {0.03 * random.direction(),
             wide * wide.transpose() + 1e-5 * Mat3::Identity(),
             random.direction(),
             random.uniform(-0.01, 0.01),
             scale * random.uniform(0.0, 1000.0),
             static_cast<std::uint8_t>(random.uniform(0.0, kMaxBodyPatches - 0.01))};
  }
  for (BodyPatch& patch : model.patches)
    patch = {random.uniform(0.3, 1.0),
             0.3,
             1.0,
             1e-3,
             0.1 * random.direction(),
             static_cast<std::uint16_t>(random.uniform(0.0, 3.0))};
  return model;
}

TEST(LocalBody, IsSymmetricPositiveAndNeverPulls) {
  test::Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const BodyModel model = random_model(random, 1.0);
    const Pose tool = moved(model.tool, 0.01 * random.direction(), 0.3 * random.direction());
    const ShellContact c = contact(model, tool);
    EXPECT_LT((c.stiffness - c.stiffness.transpose()).norm(), 1e-12 * c.stiffness.norm());
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(c.stiffness, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9 * c.stiffness.norm());
    EXPECT_GE(c.energy, 0.0);
    for (int k = 0; k < model.count; ++k) {  // Each point alone pushes along its normal.
      BodyModel one = model;
      one.points[0] = model.points[static_cast<std::size_t>(k)];
      one.count = 1;
      const Vec6 wrench = contact(one, tool).wrench;
      EXPECT_GE(wrench.head<3>().dot(one.points[0].normal), 0.0);
    }
  }
}

// The wrench is the gradient of the energy. A closed path of the tool must give no energy.
TEST(LocalBody, HasAPotential) {
  test::Random random(6);
  for (int i = 0; i < 200; ++i) {
    BodyModel model = random_model(random, 1.0);
    const Pose tool = moved(model.tool, 0.003 * random.direction(), 0.1 * random.direction());
    const Vec3 by = random.direction(), turn = random.direction();
    constexpr double kStep = 1e-6;
    const auto energy = [&](double s) {
      return contact(model, moved(tool, s * by, s * turn)).energy;
    };
    Vec6 way;
    way << by, turn;
    const double slope = (energy(kStep) - energy(-kStep)) / (2.0 * kStep);
    EXPECT_NEAR(contact(model, tool).wrench.dot(way), -slope, 1e-4 * std::abs(slope) + 1e-4);
  }
}

TEST(LocalBody, IsFiniteWhateverTheModelHolds) {
  test::Random random(7);
  constexpr double kMost = std::numeric_limits<float>::max();
  for (int i = 0; i < 500; ++i) {
    LocalBody local;
    BodyModel model = random_model(random, std::pow(10.0, random.uniform(-30.0, 35.0)));
    const double odd[] = {0.0, 1e-30, 1e30, kMost, -kMost};
    const auto pick = [&] { return odd[static_cast<std::size_t>(random.uniform(0.0, 4.99))]; };
    for (BodyPoint& point : model.points) {
      if (random.uniform(0, 1) < 0.2) point.distance = pick();
      if (random.uniform(0, 1) < 0.2) point.arm = Vec3(pick(), pick(), pick());
    }
    if (random.uniform(0, 1) < 0.3) model.coupling.stiffness = kMost;
    if (random.uniform(0, 1) < 0.3) model.coupling.max_force = kMost;
    if (random.uniform(0, 1) < 0.3) model.patches[0].velocity = Vec3(pick(), pick(), pick());
    if (random.uniform(0, 1) < 0.3) model.radius = kMost;
    Pose device = model.tool;
    for (int n = 0; n < 20; ++n) {
      local.take(model, n > 3 ? 3 : 0);
      device = moved(device, 1e-3 * random.direction(), 0.01 * random.direction());
      const BodyForce force = local.touch(device, pick() > 0 ? 0.1 : 0.0, 1e-3);
      ASSERT_TRUE(force.command.finite());
      ASSERT_GE(force.weight, 0.0);
      ASSERT_LE(force.weight, 1.0);
    }
  }
}

TEST(LocalBody, LosesItsWeightAtTheEndOfItsReach) {
  HeldBox held(Plane{});
  const Pose device = leaning(0.009, 0.0, Vec3::UnitX());
  held.settle(device);
  const BodyModel model = held.model(device);
  ASSERT_GT(model.reach, 0.001);
  LocalBody local;
  local.take(model);
  double last = 1.0;
  for (double way = 0.0; way < 1.5 * model.reach; way += 0.02 * model.reach) {
    const double w =
        local.touch({device.position + Vec3(way, 0, 0), device.orientation}, 0, 1e-3).weight;
    EXPECT_LE(w, last + 1e-12);
    EXPECT_LT(last - w, 0.15);  // The weight must not jump.
    last = w;
  }
  EXPECT_EQ(last, 0.0);
}

TEST(LocalBody, NeverAllocates) {
  HeldBox held(Plane{}, 0.4);
  const Pose device = leaning(0.009, 0.1, Vec3::UnitX());
  held.settle(device);
  LocalBody local;
  const std::size_t before = test::allocations();
  for (int i = 0; i < 100; ++i) {
    local.take(held.model(device), 5);
    local.touch(device, 0.01, 1e-3);
  }
  EXPECT_EQ(test::allocations(), before);
}

/// A movement of the hand with the box: the device's pose over time [s].
struct Movement {
  const char* name;
  Shape surface;
  Vec3 at;
  Pose (*pose)(double);
};

Pose rocks(double t) {  // The direction of the tilt rotates.
  const double a = std::numbers::pi * t;
  return {Vec3(0, 0, 0.009),
          turned(Quaternion::Identity(), 0.2 * Vec3(std::cos(a), std::sin(a), 0))};
}
Pose scrapes(double t) {
  const double a = std::numbers::pi * t;
  return {Vec3(0.03 * std::sin(a), 0, 0.009),
          turned(Quaternion::Identity(), 0.3 * std::cos(a) * Vec3::UnitY())};
}
Pose screws(double t) {
  return {Vec3(0, 0, 0.008),
          turned(Quaternion::Identity(), 0.5 * std::sin(std::numbers::pi * t) * Vec3::UnitZ())};
}
Pose taps(double t) {
  return {Vec3(0, 0, 0.0105 - 0.002 * std::sin(2.0 * std::numbers::pi * t)),
          turned(Quaternion::Identity(), 0.1 * Vec3::UnitX())};
}

struct Error {
  // late, linear, local: relative to the RMS torque; jump: [N m]
  double late = 0.0, linear = 0.0, local = 0.0, jump = 0.0;
};

/// Wrench and 6x6 stiffness at the device: coupling in series with contact and sticking friction.
struct Linearised {
  Pose device;
  Command command;
  Mat6 stiffness = Mat6::Zero();

  Linearised() = default;
  Linearised(const Pose& at, const Command& felt, const BodyTool& tool, const BodyMemory& memory)
      : device(at), command(felt) {
    const ToolCoupling& k = tool.coupling();
    Vec6 coupling;
    coupling << Vec3::Constant(k.stiffness), Vec3::Constant(k.rotational_stiffness);
    const Mat6 c = coupling.asDiagonal();
    Mat6 contact_stiffness = memory.contact.stiffness;
    if (!memory.slipping)
      for (const FrictionPatch& patch : memory.contact.gripping())
        contact_stiffness += 1e6 * patch.slip;
    stiffness = c - c * (c + contact_stiffness).inverse() * c;
  }
  Vec3 torque(const Pose& now) const {
    Vec6 way;
    way << now.position - device.position, rotation_between(device.orientation, now.orientation);
    return command.torque - (stiffness * way).tail<3>();
  }
};

/// Returns the errors over 3 s. Models are `delay` ticks late. Each `lost`-th is lost (0: none).
Error error_of(const Movement& movement, std::size_t delay, int lost) {
  HeldBox server(movement.surface, 0.4, movement.at, 800);
  std::deque<std::pair<Command, BodyModel>> on_the_way;
  std::deque<Linearised> linear_on_the_way;
  LocalBody local;
  Command late;
  Linearised linear;
  Vec3 last = Vec3::Zero(), last_true = Vec3::Zero();
  Error sum;
  double whole = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const Pose device = movement.pose(1e-3 * n);
    const Command now = server.touch(device);
    on_the_way.emplace_back(now, server.model(device));
    linear_on_the_way.emplace_back(device, now, *server.scene->tool().body, server.memory);
    if (on_the_way.size() > delay) {
      if (lost == 0 || n % lost != 0) {
        late = on_the_way.front().first;
        linear = linear_on_the_way.front();
        local.take(on_the_way.front().second, delay);
      }
      on_the_way.pop_front();
      linear_on_the_way.pop_front();
    }
    const BodyForce force = local.touch(device, 1e-3 * static_cast<double>(delay), 1e-3);
    if (n < 500) continue;
    const Vec3 torque = force.weight * force.command.torque + (1.0 - force.weight) * late.torque;
    sum.local += (torque - now.torque).squaredNorm();
    sum.late += (late.torque - now.torque).squaredNorm();
    sum.linear += (linear.torque(device) - now.torque).squaredNorm();
    whole += now.torque.squaredNorm();
    if (n > 500) sum.jump = std::max(sum.jump, ((torque - last) - (now.torque - last_true)).norm());
    last = torque;
    last_true = now.torque;
  }
  for (double* error : {&sum.late, &sum.linear, &sum.local}) *error = std::sqrt(*error / whole);
  return sum;
}

const Movement kMovements[] = {{"rock", Plane{}, Vec3::Zero(), rocks},
                               {"scrape", Plane{}, Vec3::Zero(), scrapes},
                               {"screw", Plane{}, Vec3::Zero(), screws},
                               {"tap", Plane{}, Vec3::Zero(), taps},
                               {"edge", Box{Vec3(0.15, 0.04, 0.02)}, Vec3(0, 0.04, -0.02), rocks}};

TEST(LocalBody, IsTenTimesNearerThanALateReply) {
  for (const Movement& movement : kMovements) {
    for (const int lost : {0, 3}) {
#ifdef FELTWIRE_SANITIZED
      // This case only reports a figure, and sanitizers are forty times as slow.
      if (lost > 0) continue;
#endif
      const Error error = error_of(movement, 50, lost);
      if (lost == 0)
        for (const auto& [what, value] :
             {std::pair("late", error.late), std::pair("6x6", error.linear),
              std::pair("parts", error.local)})
          RecordProperty(std::string(movement.name) + "_" + what, std::to_string(value));
      // On the edge of a solid, the points of a part touch two sides.
      const bool on_edge = std::holds_alternative<Box>(movement.surface);
      EXPECT_LT(error.local, (on_edge ? 0.7 : 0.1) * error.late) << movement.name << " " << lost;
      EXPECT_LT(error.local, (on_edge ? 1.5 : 0.5) * error.linear) << movement.name << " " << lost;
      // [N m] The torque is up to 0.05.
      EXPECT_LT(error.jump, 2e-3) << movement.name << " " << lost;
    }
  }
}

}  // namespace
}  // namespace feltwire::local_body_test
