// Moving scenes must give the recorded bits. The bits depend on the compiler, on MuJoCo, and on the
// C library's functions for the processor. tests/core/recorded_physics.txt has a record for each
// combination. This command adds a record for a new machine:
//
//   build/debug/tests/core/scene_test --gtest_filter='RecordedPhysics.*' | grep '^physics ' >>
//   tests/core/recorded_physics.txt

#include <gnu/libc-version.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "tests/core/moving.hpp"

namespace feltwire::recorded_physics_test {
namespace {

using test::body;
using test::moving;
using test::object;

/// FNV-1a hash of the bits of numbers.
class Hash {
 public:
  void add(double value) {
    // The sum makes zeros of both signs equal.
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value + 0.0);
    for (int byte = 0; byte < 8; ++byte, bits >>= 8) hash_ = (hash_ ^ (bits & 0xFF)) * kPrime;
  }
  void add(const Vec3& v) {
    for (const double x : v) add(x);
  }
  std::string text() const {
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
  }

 private:
  static constexpr std::uint64_t kPrime = 1099511628211ull;
  std::uint64_t hash_ = 14695981039346656037ull;
};

/// Returns the compiler, processor and libraries that determine the bits.
std::string machine() {
#if defined(__clang__)
  std::string text = "clang-" + std::to_string(__clang_major__);
#else
  std::string text = "gcc-" + std::to_string(__GNUC__);
#endif
#if defined(__FMA__)  // The compiler may round a * b + c only once.
  text += "-fma";
#endif
#if defined(__x86_64__)
  text += __builtin_cpu_supports("avx512f")                                 ? " x86-64-avx512"
          : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? " x86-64-avx2-fma"
          : __builtin_cpu_supports("avx")                                   ? " x86-64-avx"
                                                                            : " x86-64";
#elif defined(__aarch64__)
  text += " aarch64";
#else
  text += " other";
#endif
  return text + " glibc-" + gnu_get_libc_version() + " mujoco-" + mj_versionString();
}

/// Returns the recorded hash, or an empty text.
std::string recorded(const std::string& run) {
  std::ifstream file(FELTWIRE_SOURCE_DIR "/tests/core/recorded_physics.txt");
  const std::string begin = "physics " + machine() + " " + run + " ";
  std::string found;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(begin)) found = line.substr(begin.size());
  return found;
}

/// Returns the hash of a world's results while a hand moves in it.
std::string hash_of(const Scene& scene, int steps, const Vec3& start, const Vec3& reach) {
  World world(scene);
  test::Hand hand(world);
  Hash hash;
  for (int n = 0; n < steps; ++n) {
    // The hand follows a triangle wave in exact numbers, without the C library's sine.
    const double part = static_cast<double>(n % 512) / 256.0 - 1.0;
    const Command felt = hand.step(start + (1.0 - std::abs(part)) * reach);
    hash.add(felt.elastic);
    hash.add(felt.frictional);
    if (n % 8 != 0) continue;
    for (const Object& o : world.objects()) {
      hash.add(o.pose.position);
      for (const double x : o.pose.orientation.coeffs()) hash.add(x);
    }
  }
  return hash.text();
}

void judge(const std::string& run, const std::string& hash) {
  const std::string known = recorded(run);
  if (known.empty()) {
    std::cout << "physics " << machine() << " " << run << " " << hash << std::endl;
    GTEST_SKIP() << "no bits are recorded of '" << run << "' for " << machine()
                 << "; the line above is the one to add to tests/core/recorded_physics.txt";
  }
  EXPECT_EQ(hash, known) << "of '" << run << "' on " << machine()
                         << ": a simulation has changed its bits; if that is meant, record anew";
}

constexpr Material kWood{.stiffness = 800.0, .static_friction = 0.5, .dynamic_friction = 0.4};

/// Boxes, balls and a can fall on each other while a hand moves among them.
TEST(RecordedPhysics, Pile) {
  std::vector<Object> objects = {object("floor", Plane{}, kWood)};
  std::vector<int> body_of = {-1};
  std::vector<Body> bodies;
  for (int i = 0; i < 9; ++i) {
    const Vec3 place(0.004 * (i % 3), -0.003 * (i % 2), 0.03 + 0.045 * i);
    const Shape shape = i % 3 == 0   ? Shape(Box{Vec3(0.02, 0.015, 0.02)})
                        : i % 3 == 1 ? Shape(Sphere{0.02})
                                     : Shape(Cylinder{0.015, 0.02});
    const std::string name = "o" + std::to_string(i);
    objects.push_back(object(name.c_str(), shape, kWood, place));
    body_of.push_back(i);
    bodies.push_back(body(name.c_str(), 0.05 + 0.01 * i, place));
  }
  judge("pile", hash_of(moving(objects, body_of, bodies), 2000, {0.06, 0.0, 0.03}, {-0.07, 0, 0}));
}

/// A hand opens a door with a spring, a stop and dry friction repeatedly.
TEST(RecordedPhysics, Hinge) {
  Body door = body("door", 0.4);
  door.joint = Joint::hinge;
  door.low = -0.4;
  door.high = 1.2;
  door.stiffness = 0.3;
  door.damping = 0.01;
  door.friction = 0.02;
  const Scene scene =
      moving({object("door", Box{Vec3(0.1, 0.005, 0.1)}, kWood, {0.1, 0, 0})}, {0}, {door});
  judge("hinge", hash_of(scene, 3000, {0.15, -0.02, 0.0}, {0.0, 0.09, 0.01}));
}

/// A hand hits three weightless bodies beside their centres of mass.
TEST(RecordedPhysics, Floating) {
  std::vector<Object> objects;
  std::vector<Body> bodies;
  for (int i = 0; i < 3; ++i) {
    const Vec3 place(0.08 * i, 0.01 * i, 0.0);
    const std::string name = "o" + std::to_string(i);
    objects.push_back(object(
        name.c_str(), i == 1 ? Shape(Capsule{0.01, 0.02}) : Shape(Box{Vec3(0.02, 0.03, 0.01)}),
        kWood, place));
    bodies.push_back(body(name.c_str(), 0.1, place));
  }
  judge("floating", hash_of(moving(objects, {0, 1, 2}, bodies, test::kWeightless), 3000,
                            {-0.05, 0.012, 0.003}, {0.06, 0.0, 0.0}));
}

/// A drawer with damping and two stops.
TEST(RecordedPhysics, Slide) {
  Body drawer = body("drawer", 0.6);
  drawer.joint = Joint::slide;
  drawer.axis = Vec3::UnitX();
  drawer.low = 0.0;
  drawer.high = 0.15;
  drawer.damping = 2.0;
  drawer.friction = 0.3;
  const Scene scene = moving({object("front", Box{Vec3(0.01, 0.1, 0.05)}, kWood),
                              object("floor", Plane{}, kWood, {0, 0, -0.2})},
                             {0, -1}, {drawer});
  judge("slide", hash_of(scene, 3000, {-0.05, 0.0, 0.0}, {0.1, 0.02, 0.0}));
}

}  // namespace
}  // namespace feltwire::recorded_physics_test
