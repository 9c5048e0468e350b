#pragma once
// What each thing that a scene may need costs a step, alone; and what a scene pays that needs none.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {

/// One scene, and who is in it. All share their middle: a ball of 90 mm and 5 kN/m, beside a floor
/// and a block, that every hand glides round, 2 mm deep, at 0.1 m/s, sampled at 1 kHz.
struct SceneCase {
  std::string what;
  /// What the scene needs beyond the base, as core/scene/scene_cost_report.hpp names it.
  std::vector<std::string> needs;
  std::function<Scene()> make;
  double radius = 0.0;  // [m] of the tool: so much farther out the hand is
  std::size_t clients = 1;
  Role role = Role::operator_;
  bool local_model = false;
};

/// The base, which needs nothing but contact, first; then every need by itself, or with what it
/// cannot be without.
std::vector<SceneCase> scene_cases();

struct SceneCell {
  std::string what;
  std::size_t objects = 0;
  // Of this machine.
  double sample_ns = 0.0;      // Session::take(): contact, bound, account, reply; median of rounds
  double ratio = 1.0;          // of it to the base's, median over the rounds
  double p99_ns = 0.0;         // of single samples, the clock's reading included
  double tick_ns = 0.0;        // of what moves, median; 0: nothing does
  double scene_bytes = 0.0;    // on the heap
  double session_bytes = 0.0;  // likewise
};

/// Every case. A round is a stretch of the path in each, so that whatever slows the machine slows
/// all alike.
std::vector<SceneCell> run_trade_scene(std::span<const SceneCase> cases, std::size_t rounds);

/// What a scene of analytic objects without friction and damping answers a point with, by code that
/// knows nothing else: the same bits as Scene::touch(). A memory an object.
Command bare_touch(std::span<const Object> objects, const Tool& tool,
                   std::span<ContactMemory> memory) noexcept;

/// The base through bare_touch() and through Scene::touch(), in turns [ns], medians. Each is the
/// whole of contact and bound.
struct BareCost {
  double bare_ns = 0.0, product_ns = 0.0;
  double more_ns = 0.0;  // median of the differences
};
BareCost run_bare(std::size_t rounds);

/// Writes trade_scene.csv and trade_scene.png: what this machine took. `directory` is created.
/// Throws std::runtime_error when something cannot be written or drawn.
void write_trade_scene(const std::filesystem::path& directory, std::span<const SceneCell> cells,
                       const BareCost& bare);

/// All of it for people.
std::string trade_scene_table(std::span<const SceneCell> cells, const BareCost& bare);

}  // namespace feltwire
