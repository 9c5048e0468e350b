// A local model, rendered elsewhere, is the scene it was made of, as far as it reaches.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/contact/local_contact.hpp"
#include "core/scene/near.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire {
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

}  // namespace
}  // namespace feltwire
