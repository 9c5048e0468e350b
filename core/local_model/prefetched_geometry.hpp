#pragma once
// Surfaces of a scene that a client has in full. With them its local model is the scene's own
// contact, at every place and over every delay.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/triangle_soup.hpp"
#include "core/local_model/local_model.hpp"
#include "core/local_model/prefetched_tool.hpp"
#include "core/local_model/trial_way.hpp"
#include "core/material/contact_law.hpp"

namespace feltwire {

/// Immutable. No noexcept function allocates, throws or reads a clock, except for the destructor.
class PrefetchedSurfaces {
 public:
  virtual ~PrefetchedSurfaces() = default;
  /// Counts the scenes that the server had; never 0.
  virtual std::uint32_t version() const noexcept = 0;
  /// Whether this object of the scene is here.
  virtual bool has(std::uint16_t object) const noexcept = 0;
  /// The force of an object with this material on a point [m, world]. `memory` is in the object's
  /// frame; a new one knows nothing of the tool. Where `work` is cut off, it stays as it was, and
  /// the force means nothing. Precondition: has(object).
  virtual Command touch(std::uint16_t object, const Material& material, const Tool& tool,
                        ContactMemory& memory, WorkLimit* work) const noexcept = 0;
  Command touch(std::uint16_t object, const Material& material, const Tool& tool,
                ContactMemory& memory) const noexcept {
    return touch(object, material, tool, memory, nullptr);
  }
  /// The memory of the server's contact, which a patch tells [world], of a tool at `tool` [m,
  /// world]. Where `work` is cut off, it means nothing. Precondition: has(patch.object).
  virtual ContactMemory memory_of(const SurfacePatch& patch, const Vec3& tool,
                                  WorkLimit* work) const noexcept = 0;
  ContactMemory memory_of(const SurfacePatch& patch, const Vec3& tool) const noexcept {
    return memory_of(patch, tool, nullptr);
  }
  /// Ways on which a contact is likely to cost the most, for try_contact(). It allocates.
  virtual std::vector<TrialWay> trial_ways() const = 0;
};

/// An object's surface of triangles, as it travels. Corners from `origin`, and that in the frame of
/// the object.
struct SurfaceData {
  std::uint16_t object = 0;
  Pose pose;                   // of the object [m, world]
  Vec3 origin = Vec3::Zero();  // [m]
  bool from_inside = false;    // felt from behind the triangles' normals
  bool double_sided = false, smooth = false;
  double radius = 0.0;            // [m] of the ball that touches it; 0: a point
  double grain = 0.0;             // [m] amplitude of its roughness; 0: none
  double grain_wavelength = 1.0;  // [m]
  std::vector<Vec3> vertices;     // [m]
  std::vector<Triangle> triangles;
};

/// The objects of a scene that a client has fetched for the tool of its hand. Immutable.
struct FetchedScene {
  std::vector<std::uint16_t> objects;  // their numbers in the scene, rising
  /// For a tool that is a point or a ball; or null.
  std::shared_ptr<const PrefetchedSurfaces> surfaces;
  std::shared_ptr<const PrefetchedTool> body;  // for a tool with a body; or null
  /// The units of work that its contact may take in one tick. Beyond them the tick's contact is cut
  /// off.
  std::uint64_t most_work = WorkLimit::kUnlimited;
};

}  // namespace feltwire
