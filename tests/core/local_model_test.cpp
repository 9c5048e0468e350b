// A local model, rendered elsewhere, is the scene it was made of, as far as it reaches.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/contact/local_contact.hpp"
#include "core/scene/near.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::local_model_test {
namespace {

using test::Random;

const Material kRough{.stiffness = 1200,
                      .damping = 1.5,
                      .static_friction = 0.5,
                      .dynamic_friction = 0.3,
                      .viscous_friction = 0.7};

struct Felt {
  const char* name;
  Shape shape;
  Side side;
};
const std::vector<Felt> kFelt = {
    {"plane", Plane{}, Side::outside},
    {"ceiling", Plane{}, Side::inside},
    {"ball", Sphere{0.05}, Side::outside},
    {"hollow ball", Sphere{0.05}, Side::inside},
    {"box", Box{Vec3(0.05, 0.04, 0.02)}, Side::outside},
    {"room", Box{Vec3(0.05, 0.04, 0.03)}, Side::inside},
    {"capsule", Capsule{0.02, 0.04}, Side::outside},
    {"hollow capsule", Capsule{0.03, 0.04}, Side::inside},
    {"can", Cylinder{0.04, 0.03}, Side::outside},
    {"hollow can", Cylinder{0.04, 0.03}, Side::inside},
};

Quaternion random_rotation(Random& random) {
  const Vec3 axis = random.direction();
  return Quaternion(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), axis));
}

Scene one(const Felt& felt, Random& random, const Material& material = kRough) {
  Object o;
  o.name = felt.name;
  o.shape = felt.shape;
  o.felt_from = felt.side;
  o.pose = {random.uniform(0.0, 0.5) * random.direction(), random_rotation(random)};
  o.material = material;
  return Scene("one", {o});
}

/// A hand that wanders about the middle of a scene's object, a fraction of a millimetre a sample.
class Wanderer {
 public:
  Wanderer(Random& random, const Pose& about) : random_(random), about_(about) {
    position_ = random.uniform(0.01, 0.07) * random.direction();
  }
  Tool step() {
    velocity_ = 0.97 * velocity_ + random_.uniform(0.0, 3e-5) * random_.direction();
    position_ += velocity_;
    position_ *= 0.9995;
    return {about_.position + about_.orientation * position_,
            about_.orientation * Vec3(velocity_ / 1e-3)};
  }

 private:
  Random& random_;
  Pose about_;
  Vec3 position_, velocity_ = Vec3::Zero();
};

/// Relative to the force, with what 0.1 nm of depth come to beside it.
void expect_near(const Command& a, const Command& b, double relative, const char* name) {
  const double scale = relative * (a.force().norm() + b.force().norm()) + relative * 0.1;
  EXPECT_LE((a.elastic - b.elastic).norm(), scale) << name;
  EXPECT_LE((a.frictional - b.frictional).norm(), scale) << name;
}

// A model every 40 ms of a hand that wanders in and out: at every tick between, where the model
// speaks alone, both answer alike, friction and its memory included.
TEST(LocalModel, IsTheObjectItWasMadeOf) {
  Random random(1);
  for (const Felt& felt : kFelt) {
    int touched = 0, slipped = 0, spoke = 0, ticks = 0;
    for (int run = 0; run < 60; ++run) {
      const Scene scene = one(felt, random);
      TouchMemory memory = scene.memory();
      LocalContact local;
      Wanderer hand(random, scene.objects()[0].pose);
      bool followed = true;  // the model spoke alone ever since the two agreed
      for (int n = 0; n < 1200; ++n) {
        const Tool tool = hand.step();
        const Command truth = scene.touch(tool, memory);
        const LocalForce force = local.touch(tool, 0.0, 1e-3);
        followed = followed && force.weight == 1.0;
        ++ticks;
        if (force.weight == 1.0 && followed) {
          ++spoke;
          touched += truth.elastic.norm() > 0.0 ? 1 : 0;
          slipped += memory[0].slipping ? 1 : 0;
          expect_near(force.command, truth, 1e-9, felt.name);
        }
        if (n % 40 == 0) {
          // One that has not followed begins anew, with the model's memory.
          if (!followed) local.clear();
          local.take(local_model(scene, tool.position, memory));
          followed = true;
        }
        if (testing::Test::HasFailure()) FAIL() << felt.name << " run " << run << " tick " << n;
      }
    }
    EXPECT_GT(touched, 1000) << felt.name;
    EXPECT_GT(slipped, 100) << felt.name;
    EXPECT_GT(spoke, ticks / 3) << felt.name;
  }
}

Scene of(std::vector<Object> objects) { return Scene("scene", std::move(objects)); }
Object object(const char* name, const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = name;
  o.shape = shape;
  o.pose.position = position;
  o.material = kRough;
  return o;
}

struct Followed {
  int touched = 0, together = 0, spoke = 0, ticks = 0;
};

/// Hands about places on the surfaces of a scene, a model every 20 ms; where the models speak alone
/// they answer as the scene does.
Followed follow(const Scene& scene, Random& random, double width) {
  Followed sum;
  for (int run = 0; run < 150; ++run) {
    TouchMemory memory = scene.memory();
    LocalContact local;
    Vec3 place = random.uniform(0.0, 0.5 * width) * random.direction();
    const LocalModel near = local_model(scene, place, memory);
    if (near.count > 0) place = near.patches[0].point - 1e-3 * near.patches[0].normal;
    Vec3 position = place, velocity = Vec3::Zero();
    bool followed = true;  // the model spoke alone ever since the two agreed
    for (int n = 0; n < 600; ++n) {
      velocity = 0.97 * velocity + random.uniform(0.0, 3e-5) * random.direction();
      position += velocity + 1e-3 * (place - position);
      const Tool tool{position, velocity / 1e-3};
      const Command truth = scene.touch(tool, memory);
      const LocalForce force = local.touch(tool, 0.0, 1e-3);
      followed = followed && force.weight == 1.0;
      ++sum.ticks;
      if (followed) {
        ++sum.spoke;
        int count = 0;
        for (const ContactMemory& m : memory) count += m.touching ? 1 : 0;
        sum.touched += count > 0 ? 1 : 0;
        sum.together += count > 1 ? 1 : 0;
        expect_near(force.command, truth, 1e-9, scene.name().c_str());
      }
      if (n % 20 == 0) {
        if (!followed) local.clear();
        local.take(local_model(scene, position, memory));
        followed = true;
      }
      if (testing::Test::HasFailure()) {
        ADD_FAILURE() << "run " << run << " tick " << n << " at " << position.transpose();
        return sum;
      }
    }
  }
  return sum;
}

TEST(LocalModel, IsTheRoomThatItWasMadeOf) {
  Random random(2);
  const Followed sum =
      follow(load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json"), random, 0.4);
  EXPECT_GT(sum.touched, 10000);
  EXPECT_GT(sum.spoke, sum.ticks / 2);
}

// Solids that stand in one another: more at once than a model describes.
TEST(LocalModel, IsTheHeapThatItWasMadeOf) {
  Random random(5);
  Followed sum;
  for (int heap = 0; heap < 5; ++heap) {
    std::vector<Object> objects;
    for (std::size_t i = 0; i < kFelt.size(); ++i) {
      if (kFelt[i].side == Side::inside) continue;
      objects.push_back(
          object(kFelt[i].name, kFelt[i].shape, random.uniform(0.0, 0.05) * random.direction()));
      objects.back().pose.orientation = random_rotation(random);
    }
    const Followed one_heap = follow(of(objects), random, 0.2);
    sum.touched += one_heap.touched;
    sum.together += one_heap.together;
    sum.spoke += one_heap.spoke;
    sum.ticks += one_heap.ticks;
  }
  EXPECT_GT(sum.touched, 50000);
  EXPECT_GT(sum.together, 10000);
  EXPECT_GT(sum.spoke, sum.ticks / 10);
}

TEST(LocalModel, KnowsAWallBeforeItIsTouched) {
  const Scene floor = of({object("floor", Plane{})});
  const LocalModel model = local_model(floor, Vec3(0.3, -0.2, 0.05), floor.memory());
  ASSERT_EQ(model.count, 1);
  EXPECT_EQ(model.patches[0].point, Vec3(0.3, -0.2, 0.0));
  EXPECT_EQ(model.patches[0].normal, Vec3::UnitZ());
  EXPECT_FALSE(model.patches[0].touching);
  EXPECT_EQ(model.reach, kModelReach);
  // Farther than any model reaches there is nothing, and that is known too.
  const LocalModel far = local_model(floor, Vec3(0, 0, 0.11), floor.memory());
  EXPECT_EQ(far.count, 0);
  EXPECT_EQ(far.reach, kModelReach);
  const Scene block = of({object("block", Box{Vec3(0.05, 0.05, 0.05)})});
  const auto faces = [&](double x, double z) {
    return local_model(block, Vec3(x, 0, z), block.memory()).count;
  };
  EXPECT_EQ(faces(0.0, 0.151), 0);
  EXPECT_EQ(faces(0.0, 0.149), 1);   // the edges are farther than 0.1 m
  EXPECT_EQ(faces(0.04, 0.149), 2);  // one of them is not
  EXPECT_EQ(faces(0.06, 0.149), 2);  // beyond both: the edge itself
  EXPECT_EQ(faces(0.06, 0.1495), 0);
}

TEST(LocalModel, ReachEndsBeforeWhatIsLeftOut) {
  std::vector<Object> balls;
  for (int i = 0; i < 5; ++i)
    balls.push_back(object(
        ("ball " + std::to_string(i)).c_str(), Sphere{0.01},
        Vec3(0.0, 0.0, 0.0) + (0.02 + 0.01 * i) * Vec3(std::cos(1.3 * i), std::sin(1.3 * i), 0.0)));
  const Scene scene = of(balls);
  const LocalModel model = local_model(scene, Vec3::Zero(), scene.memory());
  ASSERT_EQ(model.count, 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(model.patches[static_cast<std::size_t>(i)].object, i);
  EXPECT_NEAR(model.reach, 0.04, 1e-15);  // of the fourth ball's surface
}

// Side and ends of a capsule are one smooth surface but no single patch.
TEST(LocalModel, ReachEndsWhereACapsuleBendsAway) {
  const Scene scene = of({object("capsule", Capsule{0.02, 0.04})});
  const auto at = [&](double x, double z) {
    return local_model(scene, Vec3(x, 0.0, z), scene.memory());
  };
  for (const LocalModel& model : {at(0.021, 0.03), at(0.019, 0.03)}) {
    ASSERT_EQ(model.count, 1);
    EXPECT_EQ(model.patches[0].axis, Vec3::UnitZ());
    EXPECT_NEAR(model.patches[0].radius, 0.01, 1e-15);
  }
  EXPECT_NEAR(at(0.019, 0.03).reach, 0.01, 1e-15);
  EXPECT_NEAR(at(0.05, 0.0).reach, 0.05, 1e-15);  // 40 mm along and 30 mm in
  EXPECT_EQ(at(0.0, 0.07).patches[0].axis, Vec3::Zero());
  EXPECT_NEAR(at(0.0, 0.07).reach, 0.03, 1e-15);
}

TEST(LocalModel, InFourWallsAtOnceItSaysNothing) {
  std::vector<Object> walls;
  for (int i = 0; i < 4; ++i)
    walls.push_back(object(("wall " + std::to_string(i)).c_str(), Plane{}));
  const Scene scene = of(walls);
  TouchMemory memory = scene.memory();
  scene.touch({Vec3(0, 0, -1e-3), Vec3::Zero()}, memory);
  const LocalModel model = local_model(scene, Vec3(0, 0, -1e-3), memory);
  EXPECT_EQ(model.reach, 0.0);
  LocalContact local;
  local.take(model);
  EXPECT_EQ(local.touch({Vec3(0, 0, -1e-3), Vec3::Zero()}, 0.0, 1e-3).weight, 0.0);
}

// A hand that entered a thin sheet from above and is nearer to its lower face by now.
TEST(LocalModel, KeepsTheFaceThatTheToolEnteredBy) {
  const Scene sheet = of({object("sheet", Box{Vec3(0.1, 0.1, 1e-3)})});
  TouchMemory memory = sheet.memory();
  LocalContact local;
  for (double z = 9e-4; z > -9e-4; z -= 1e-4) {
    const Tool tool{Vec3(0.01, 0.02, z), Vec3::Zero()};
    const Command truth = sheet.touch(tool, memory);
    const LocalModel model = local_model(sheet, tool.position, memory);
    ASSERT_GE(model.count, 1);
    EXPECT_EQ(model.patches[0].normal, Vec3::UnitZ());
    EXPECT_TRUE(model.patches[0].touching);
    local.clear();  // nothing but the model knows it
    local.take(model);
    expect_near(local.touch(tool, 0.0, 1e-3).command, truth, 1e-9, "sheet");
  }
}

// The state that a model describes is old: what this side remembers of the contact is newer.
TEST(LocalModel, AnUpdateKeepsTheStickPointAndTheFaceOfThisSide) {
  const Scene scene = of({object("block", Box{Vec3(0.05, 0.05, 0.05)})});
  TouchMemory memory = scene.memory();
  LocalContact local;
  const auto tool = [](double x, double z) { return Tool{Vec3(x, 0.0, z), Vec3::Zero()}; };
  local.take(local_model(scene, tool(0.04, 0.051).position, memory));
  local.touch(tool(0.04, 0.049), 0.0, 1e-3);  // in from above
  const Command before = local.touch(tool(0.0402, 0.049), 0.0, 1e-3).command;
  EXPECT_NEAR(before.frictional.x(), -1200 * 2e-4, 1e-9);  // the stick point is 0.2 mm behind

  scene.touch(tool(0.0495, 0.047), memory);  // while the server has it in by the side
  EXPECT_EQ(memory[0].feature.normal, Vec3::UnitX());
  local.take(local_model(scene, tool(0.0495, 0.047).position, memory));
  expect_near(local.touch(tool(0.0402, 0.049), 0.0, 1e-3).command, before, 1e-9, "block");
}

// A surface in motion is the resting one for who moves along with it.
TEST(LocalModel, MovingSurfacesAreTheRestingOnesSeenInMotion) {
  Random random(3);
  for (int run = 0; run < 200; ++run) {
    const Felt& felt = kFelt[static_cast<std::size_t>(run) % kFelt.size()];
    const Scene scene = one(felt, random);
    const Vec3 drift = random.uniform(0.0, 0.5) * random.direction();  // [m/s]
    TouchMemory memory = scene.memory();
    LocalContact resting, moving;
    Wanderer hand(random, scene.objects()[0].pose);
    double age = 0.0;
    for (int n = 0; n < 400; ++n) {
      Tool tool = hand.step();
      scene.touch(tool, memory);
      const double time = 1e-3 * n;
      if (n % 50 == 0) {
        LocalModel model = local_model(scene, tool.position, memory);
        // It comes late, and where it was made everything stood at the origin of this frame.
        age = random.uniform(0.0, 0.03);
        model.reach = 1.0;
        for (SurfacePatch& patch : model.patches) patch.radius = 1.0;
        resting.take(model);
        for (SurfacePatch& patch : model.patches) {
          patch.velocity = drift;
          patch.point += (time - age) * drift;
          patch.anchor += (time - age) * drift;
        }
        model.center += time * drift;
        moving.take(model);
      }
      const Command truth = resting.touch(tool, 0.0, 1e-3).command;
      tool.position += time * drift;
      tool.velocity += drift;
      expect_near(moving.touch(tool, age, 1e-3).command, truth, 1e-8, felt.name);
      age += 1e-3;
      if (testing::Test::HasFailure()) FAIL() << felt.name << " run " << run << " tick " << n;
    }
  }
}

TEST(LocalModel, NoModelMakesAForceThatIsNotFinite) {
  Random random(4);
  int forces = 0;
  for (int run = 0; run < 20000; ++run) {
    LocalModel model;
    model.reach = random.chance(0.2) ? std::numeric_limits<double>::infinity() : 1.0;
    model.count = 3;
    for (SurfacePatch& p : model.patches) {
      p.point = random.vector(-300.0, 300.0);
      if (random.chance(0.5)) p.point = random.vector(-3.0, -1.0);
      p.normal = random.direction();
      p.curvature = random.chance(0.5) ? random.decades(-300.0, 300.0) : 0.0;
      if (random.chance(0.5)) p.axis = random.chance(0.3) ? p.normal : random.direction();
      p.velocity = random.vector(-300.0, 300.0);
      p.anchor = random.vector(-300.0, 300.0);
      p.radius = random.chance(0.5) ? std::numeric_limits<double>::infinity() : 1.0;
      p.touching = random.chance(0.5);
      p.joined = random.chance(0.5);
      p.object = static_cast<std::uint16_t>(random.uniform(0.0, 2.0));
      p.material.stiffness = std::abs(random.decades(-300.0, 300.0));
      p.material.damping = std::abs(random.decades(-300.0, 300.0));
      p.material.static_friction = std::abs(random.decades(-300.0, 300.0));
    }
    LocalContact local;
    local.take(model);
    for (int n = 0; n < 3; ++n) {
      const LocalForce force =
          local.touch({random.vector(-4.0, -1.0), random.vector(-3.0, 1.0)}, 0.01, 1e-3);
      ASSERT_TRUE(force.command.finite());
      ASSERT_TRUE(force.weight >= 0.0 && force.weight <= 1.0);
      forces += force.command.elastic.norm() > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(forces, 1000);
}

TEST(LocalModel, NeitherSideAllocates) {
  const Scene room = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json");
  TouchMemory memory = room.memory();
  LocalContact local;
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) {
    const Tool tool{Vec3(1e-4 * n, 2e-4 * n, -0.051), Vec3::Zero()};
    room.touch(tool, memory);
    local.take(local_model(room, tool.position, memory));
    local.touch(tool, 0.0, 1e-3);
  }
  EXPECT_EQ(test::allocations(), before);
}

TEST(LocalModel, APositionThatIsNoneGivesNone) {
  const Scene floor = of({object("floor", Plane{})});
  const double nan = std::nan("");
  EXPECT_EQ(local_model(floor, Vec3(0, nan, 0), floor.memory()).reach, 0.0);
  EXPECT_EQ(local_model(floor, Vec3::Zero(), TouchMemory(3)).reach, 0.0);
}

}  // namespace
}  // namespace feltwire::local_model_test
