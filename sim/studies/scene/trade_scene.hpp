#pragma once
// The cost of each feature of a scene in a step, alone; and the cost of a scene without any.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {

/// A scene with its sessions. All scenes have the same middle: a ball of 90 mm and 5 kN/m, beside a
/// floor and a block. Every hand glides round it, 2 mm deep, at 0.1 m/s, sampled at 1 kHz.
struct SceneCase {
  std::string what;
  /// The features of the scene beyond the base, with the names of core/scene/scene_cost_report.hpp.
  std::vector<std::string> needs;
  std::function<Scene()> make;
  double radius = 0.0;  // [m] of the tool: the hand is so much farther out
  std::size_t clients = 1;
  Role role = Role::operator_;
  bool local_model = false;
};

/// The base, which needs only contact, first; then every feature by itself, or with the features
/// that it requires.
std::vector<SceneCase> scene_cases();

struct SceneCell {
  std::string what;
  std::size_t objects = 0;
  // Depends on this machine.
  double sample_ns = 0.0;      // Session::take(): contact, bound, account, reply; median of rounds
  double ratio = 1.0;          // of it to the base's, median over the rounds
  double p99_ns = 0.0;         // of single samples, the clock's reading included
  double tick_ns = 0.0;        // of the moving objects, median; 0: there are none
  double scene_bytes = 0.0;    // on the heap
  double session_bytes = 0.0;  // on the heap
};

/// Every case. A round is a stretch of the path in each, so that other work on the machine slows
/// all cases alike.
std::vector<SceneCell> run_trade_scene(std::span<const SceneCase> cases, std::size_t rounds);

/// The force of a scene of analytic objects without friction and damping at a point, by code
/// without other features: the same bits as Scene::touch(). One memory for each object.
Command bare_touch(std::span<const Object> objects, const Tool& tool,
                   std::span<ContactMemory> memory) noexcept;

/// The base through bare_touch() and through Scene::touch(), in turns [ns], medians. Each is
/// contact and bound together.
struct BareCost {
  double bare_ns = 0.0, product_ns = 0.0;
  double more_ns = 0.0;  // median of the differences
};
BareCost run_bare(std::size_t rounds);

/// Writes trade_scene.csv and trade_scene.png with the times on this machine. `directory` is
/// created. Throws std::runtime_error if something cannot be written or drawn.
void write_trade_scene(const std::filesystem::path& directory, std::span<const SceneCell> cells,
                       const BareCost& bare);

/// All results for people.
std::string trade_scene_table(std::span<const SceneCell> cells, const BareCost& bare);

}  // namespace feltwire
