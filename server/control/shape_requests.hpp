#pragma once
// The answers to clients that draw a scene: its objects, guides and tools (PROTOCOL.md, "Shapes of
// a scene").

#include <asio/io_context.hpp>
#include <asio/thread_pool.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/geometry/triangle_soup.hpp"
#include "core/grid/distance_grid.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/scene_in_view.hpp"

namespace feltwire {

/// The next shapes of the group, at most control::kMaxShapes. A name longer than control::kMaxName
/// is shortened.
control::ShapeDescriptions described_shapes(const SceneInView::CurrentScene& current,
                                            const control::DescribeShapes& request);

/// Gives out vertices and triangles. Owns the triangles of grids: they take 30 to 70 ms, so a
/// thread of its own makes them, once for each version of a scene. It is on the control thread.
class ShapeParts {
 public:
  using Answer = std::function<void(control::Message)>;

  /// `io` runs on the control thread, and outlives this.
  explicit ShapeParts(asio::io_context& io) : io_(io) {}

  /// Answers with the next part or the refusal, at once or when the triangles are made. `scene`:
  /// the number of the scene among those of the server.
  void part(std::size_t scene, const SceneInView::CurrentScene& current,
            const control::GetShape& request, Answer answer);
  /// Frees the triangles of other versions of a scene.
  void forget_others(std::size_t scene, std::uint32_t version);
  /// The number of grids whose triangles are kept or made.
  std::size_t grids() const { return grids_.size(); }

 private:
  struct Key {
    std::size_t scene = 0;
    std::uint32_t version = 0;
    std::uint32_t object = 0;
    bool operator<(const Key& other) const {
      return std::tie(scene, version, object) < std::tie(other.scene, other.version, other.object);
    }
  };
  struct Surface {
    std::optional<TriangleSoup> triangles{};  // empty: they are being made
    std::vector<std::pair<control::GetShape, Answer>> waiting{};
  };
  void make(const Key& key, std::shared_ptr<const DistanceGrid<float>> field);
  void enter(const Key& key, std::optional<TriangleSoup> made);

  asio::io_context& io_;
  std::map<Key, Surface> grids_;
  // Empty until the first grid. The last member: its thread uses the others.
  std::optional<asio::thread_pool> worker_;
};

}  // namespace feltwire
