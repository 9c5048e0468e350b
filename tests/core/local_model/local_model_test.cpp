// A local model must equal its scene within its valid radius.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/followed_hand.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::local_model_test {
namespace {

using test::Random;

const Material kRough{.stiffness = 1200,
                      .damping = 1.5,
                      .static_friction = 0.5,
                      .dynamic_friction = 0.3,
                      .viscous_friction = 0.7};

struct TouchedShape {
  const char* name;
  Shape shape;
  Side side;
};
const std::vector<TouchedShape> kFelt = {
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

Scene one(const TouchedShape& felt, Random& random, const Material& material = kRough) {
  Object o;
  o.name = felt.name;
  o.shape = felt.shape;
  o.felt_from = felt.side;
  o.pose = {random.uniform(0.0, 0.5) * random.direction(), random_rotation(random)};
  o.material = material;
  return Scene("one", {o});
}

/// A hand moves at random about an object, a fraction of a millimetre per sample.
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

/// Compares relative to the force, plus the force of 0.1 nm of depth.
void expect_near(const Command& a, const Command& b, double relative, const char* name) {
  const double scale = relative * (a.force().norm() + b.force().norm()) + relative * 0.1;
  EXPECT_LE((a.elastic - b.elastic).norm(), scale) << name;
  EXPECT_LE((a.frictional - b.frictional).norm(), scale) << name;
}

// A hand moves in and out and gets a model every 40 ms. While the model alone gives the force, this
// force must equal the scene's force, including friction and its memory.
TEST(LocalModel, IsTheObjectItWasMadeOf) {
  Random random(1);
  for (const TouchedShape& felt : kFelt) {
    int touched = 0, slipped = 0, spoke = 0, ticks = 0;
    for (int run = 0; run < test::rounds(60); ++run) {
      const Scene scene = one(felt, random);
      test::FollowedHand hand(scene, 40);
      Wanderer wanderer(random, scene.objects()[0].pose);
      for (int n = 0; n < 1200; ++n) {
        ++ticks;
        if (hand.step(wanderer.step())) {
          ++spoke;
          touched += hand.truth().elastic.norm() > 0.0 ? 1 : 0;
          slipped += hand.memory()[0].slipping ? 1 : 0;
          expect_near(hand.said(), hand.truth(), 1e-9, felt.name);
        }
        if (::testing::Test::HasFailure()) FAIL() << felt.name << " run " << run << " tick " << n;
      }
    }
    EXPECT_GT(touched, test::rounds(1000)) << felt.name;
    EXPECT_GT(slipped, test::rounds(100)) << felt.name;
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

/// Hands move at random near a scene's surfaces, with a model every 20 ms. While the models alone
/// give the force, the force must equal the scene's.
Followed follow(const Scene& scene, Random& random, double width) {
  Followed sum;
  for (int run = 0; run < 150; ++run) {
    test::FollowedHand hand(scene, 20);
    Vec3 place = random.uniform(0.0, 0.5 * width) * random.direction();
    const LocalModel near = local_model(scene, place, hand.memory());
    if (near.count > 0) place = near.patches[0].point - 1e-3 * near.patches[0].normal;
    test::WanderingHand wanderer(random, place);
    for (int n = 0; n < 600; ++n) {
      ++sum.ticks;
      if (hand.step(wanderer.step())) {
        ++sum.spoke;
        int count = 0;
        for (const ContactMemory& m : hand.memory()) count += m.touching ? 1 : 0;
        sum.touched += count > 0 ? 1 : 0;
        sum.together += count > 1 ? 1 : 0;
        expect_near(hand.said(), hand.truth(), 1e-9, scene.name().c_str());
      }
      if (::testing::Test::HasFailure()) {
        ADD_FAILURE() << "run " << run << " tick " << n;
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

// The tool touches more overlapping solids than a model can describe.
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

// A hand entered a thin sheet from above and is now nearer to the lower face.
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
    local.clear();  // Only the model still has the face.
    local.take(model);
    expect_near(local.touch(tool, 0.0, 1e-3).command, truth, 1e-9, "sheet");
  }
}

// The contact state in a model is old. The client's own contact memory is newer and must stay.
TEST(LocalModel, AnUpdateKeepsTheStickPointAndTheFaceOfThisSide) {
  const Scene scene = of({object("block", Box{Vec3(0.05, 0.05, 0.05)})});
  TouchMemory memory = scene.memory();
  LocalContact local;
  const auto tool = [](double x, double z) { return Tool{Vec3(x, 0.0, z), Vec3::Zero()}; };
  local.take(local_model(scene, tool(0.04, 0.051).position, memory));
  local.touch(tool(0.04, 0.049), 0.0, 1e-3);  // The hand enters from above.
  const Command before = local.touch(tool(0.0402, 0.049), 0.0, 1e-3).command;
  // The stick point is 0.2 mm away from the tool.
  EXPECT_NEAR(before.frictional.x(), -1200 * 2e-4, 1e-9);

  scene.touch(tool(0.0495, 0.047), memory);  // The server's tool enters from the side meanwhile.
  EXPECT_EQ(memory[0].feature.normal, Vec3::UnitX());
  local.take(local_model(scene, tool(0.0495, 0.047).position, memory));
  expect_near(local.touch(tool(0.0402, 0.049), 0.0, 1e-3).command, before, 1e-9, "block");
}

// If a hand moves along with a moving surface, the force must equal the force of a resting surface.
TEST(LocalModel, MovingSurfacesAreTheRestingOnesSeenInMotion) {
  Random random(3);
  for (int run = 0; run < 200; ++run) {
    const TouchedShape& felt = kFelt[static_cast<std::size_t>(run) % kFelt.size()];
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
        // The model arrives late. At its creation, all positions were at the origin of the moving
        // frame.
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
      if (::testing::Test::HasFailure()) FAIL() << felt.name << " run " << run << " tick " << n;
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
      p.faceted = random.chance(0.5);
      p.rough = random.chance(0.5);
      if (random.chance(0.5)) p.offset = random.decades(-3.0, 300.0);
      p.object = static_cast<std::uint16_t>(random.uniform(0.0, 2.0));
      p.material.stiffness = std::abs(random.decades(-300.0, 300.0));
      p.material.damping = std::abs(random.decades(-300.0, 300.0));
      p.material.static_friction = std::abs(random.decades(-300.0, 300.0));
    }
    LocalContact local;
    const Command answered{.elastic = random.vector(-300.0, 300.0)};
    local.take(model, &answered);
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

}  // namespace
}  // namespace feltwire::local_model_test
