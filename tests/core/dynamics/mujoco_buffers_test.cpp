// A simulation allocates its usual memory and grows on demand. Its results must not depend on the
// growth.

#include "core/dynamics/mujoco_buffers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "core/dynamics/mujoco_sort.hpp"
#include "tests/core/moving.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::mujoco_buffers_test {
namespace {

using mujoco::bytes;
using mujoco::first_room;
using mujoco::Simulation;

constexpr double kHalf = 0.02;  // [m]

/// Returns boxes. The first is a millimetre above a table, and the others are at `height` [m].
std::string boxes(int count, const std::string& size, double height) {
  std::string xml = "<mujoco>" + size +
                    "<option timestep='0.001' cone='elliptic' noslip_iterations='5'/><worldbody>"
                    "<geom type='plane' size='0 0 1' condim='3'/>";
  for (int i = 0; i < count; ++i)
    xml += "<body pos='" + std::to_string(0.05 * (i % 10)) + " " + std::to_string(0.05 * (i / 10)) +
           " " + std::to_string(i == 0 ? 0.021 : height) +
           "'><freejoint/><geom type='box' size='0.02 0.02 0.02' mass='0.1' "
           "condim='3'/></body>";
  return xml + "</worldbody></mujoco>";
}

mujoco::Model model_of(int count, const std::string& size = {}, double height = 0.021) {
  mujoco::Loaded loaded = mujoco::load_text(boxes(count, size, height));
  EXPECT_NE(loaded.model, nullptr) << loaded.error;
  mujoco::leave_room_open(*loaded.model);
  return std::move(loaded.model);
}

std::vector<double> run(Simulation& simulation, int steps) {
  for (int n = 0; n < steps; ++n) {
    EXPECT_TRUE(simulation.advance());
    EXPECT_TRUE(simulation.evaluate());
  }
  const mjData& data = *simulation.data();
  return {data.qpos, data.qpos + simulation.model().nq};
}

double lowest(const std::vector<double>& coordinates) {
  double least = 1.0;
  for (std::size_t i = 2; i < coordinates.size(); i += 7) least = std::min(least, coordinates[i]);
  return least;
}

TEST(MujocoRoom, FewBodiesTakeLittle) {
  const auto model = model_of(1);
  const mujoco::BufferSizes room = first_room(*model);
  EXPECT_GE(room.contacts, 20);
  EXPECT_GE(room.rows, 60);
  EXPECT_LT(bytes(*model, room) + 8.0 * room.stack, 4e5);
  for (const int count : {10, 100, 300}) {
    const auto many = model_of(count);
    EXPECT_LE(bytes(*many, first_room(*many)), mujoco::kFirstMemory);
  }
}

// Fifty boxes on a table have two hundred contacts, but MuJoCo's default memory holds a hundred.
// Without growth the other boxes would fall through the table.
TEST(MujocoRoom, NoneFallsThroughForWantOfRoom) {
  std::vector<Object> objects{test::object("table", Plane{})};
  std::vector<Body> bodies;
  std::vector<int> body_of{-1};
  for (int i = 0; i < 50; ++i) {
    const std::string name = "box " + std::to_string(i);
    const Vec3 at(0.05 * (i % 10), 0.05 * (i / 10), kHalf);
    objects.push_back(test::object(name.c_str(), Box{Vec3::Constant(kHalf)}, {}, at));
    bodies.push_back(test::body(name.c_str(), 0.1, at));
    body_of.push_back(i);
  }
  const Scene scene = test::moving(objects, body_of, bodies);
  World world(scene);
  for (int n = 0; n < 300; ++n) ASSERT_TRUE(world.step());
  for (std::size_t i = 1; i < world.objects().size(); ++i)
    EXPECT_NEAR(world.objects()[i].pose.position.z(), kHalf, 2e-4) << i;
  EXPECT_EQ(world.counters().warnings, 0u);
}

// A simulation that grows must give the same bits as a simulation with enough memory from the
// start.
TEST(MujocoRoom, WhoGrowsGoesOnAsIfItHadHadTheRoom) {
  const auto small = model_of(100);
  const auto large = model_of(100, "<size nconmax='1000' njmax='3500' nstack='30000000'/>");
  Simulation grows(*small), has(*large);
  const mujoco::BufferSizes first = first_room(*small);
  EXPECT_EQ(has.room().contacts, 1000);
  const auto a = run(grows, 60), b = run(has, 60);
  EXPECT_EQ(a, b);
  EXPECT_GT(grows.room().contacts, first.contacts);
  EXPECT_GT(grows.room().rows, first.rows);
  EXPECT_GT(grows.room().stack, first.stack);
  EXPECT_FALSE(grows.is_full());
  EXPECT_EQ(has.room().contacts, 1000);
  EXPECT_NEAR(lowest(a), kHalf, 1e-3);
}

// A tick must not allocate, with one exception (docs/moving.md): a tick with more contacts than all
// ticks before may grow the memory.
TEST(MujocoRoom, OnlyATickThatGrowsAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer brings its own malloc";
#endif
  const std::size_t counting = test::allocations();
  mju_free(mju_malloc(8));  // The counter must include MuJoCo's memory.
  EXPECT_EQ(test::allocations(), counting + 2);

  const auto model = model_of(100);
  Simulation simulation(*model);
  int grown = 0;
  for (int n = 0; n < 300; ++n) {
    const mujoco::BufferSizes room = simulation.room();
    const std::size_t before = test::allocations();
    ASSERT_TRUE(simulation.advance() && simulation.evaluate());
    const bool allocated = test::allocations() != before;
    const mujoco::BufferSizes now = simulation.room();
    const bool grew =
        now.contacts != room.contacts || now.rows != room.rows || now.stack != room.stack;
    EXPECT_EQ(allocated, grew) << n;
    grown += grew ? 1 : 0;
  }
  EXPECT_GE(grown, 1);
  EXPECT_LE(grown, 5);
}

#ifndef FELTWIRE_SANITIZED
/// A thread's first sort must allocate only its memory, without a registered destructor. glibc ends
/// the program if no memory is left for such a registration.
TEST(MujocoSort, AThreadTakesMemoryOnceAndForItsRoomOnly) {
  std::array<std::size_t, 2> taken{};
  std::vector<int> numbers(1000);
  std::thread([&] {
    for (std::size_t& of_this_sort : taken) {
      for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<int>(numbers.size() - i);
      const std::size_t before = test::allocations();
      mujoco::sort_stably(
          numbers.data(), numbers.size(), sizeof(int),
          [](const void* a, const void* b, void*) {
            return *static_cast<const int*>(a) - *static_cast<const int*>(b);
          },
          nullptr);
      of_this_sort = test::allocations() - before;
    }
  }).join();
  EXPECT_EQ(taken[0], 1u);
  EXPECT_EQ(taken[1], 0u);
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
}
#endif

// A single box lands, and a hundred are in the air. The stack is then too small for Newton's
// matrices.
TEST(MujocoRoom, AStackThatTheSolverFindsTooSmallGrows) {
  const auto small = model_of(100, {}, 5.0);
  const auto large = model_of(100, "<size nconmax='300' njmax='900' nstack='5000000'/>", 5.0);
  Simulation grows(*small), has(*large);
  const int first = grows.room().stack;
  EXPECT_EQ(run(grows, 10), run(has, 10));
  EXPECT_EQ(grows.room().stack, first);
  EXPECT_EQ(run(grows, 20), run(has, 20));
  EXPECT_GT(grows.room().stack, first);
}

TEST(MujocoRoom, WhatAFileSaysStays) {
  const auto model = model_of(20, "<size nconmax='9' njmax='40' nstack='200000'/>");
  Simulation simulation(*model);
  const auto coordinates = run(simulation, 300);
  EXPECT_EQ(simulation.room().contacts, 9);
  EXPECT_EQ(simulation.room().rows, 40);
  EXPECT_EQ(simulation.room().stack, 200000);
  EXPECT_GT(simulation.data()->warning[mjWARN_CONTACTFULL].number, 0);
  EXPECT_LT(lowest(coordinates), 0.0);  // A setting in the file causes this value.
}

// At the memory limit, the simulation must drop contacts, warn and continue. The stack must still
// fit.
TEST(MujocoRoom, AtTheMostItIsFull) {
  const auto model = model_of(100);
  Simulation simulation(*model, 0.5 * bytes(*model, first_room(*model)));
  const auto coordinates = run(simulation, 60);
  EXPECT_TRUE(simulation.is_full());
  EXPECT_GT(simulation.data()->warning[mjWARN_CONTACTFULL].number, 0);
  for (const double x : coordinates) EXPECT_TRUE(std::isfinite(x));
}

}  // namespace
}  // namespace feltwire::mujoco_buffers_test
