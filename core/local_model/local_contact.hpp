#pragma once
// Renders a local model: the contact of a tool with the model's patches, at the client's rate.

#include <array>
#include <cstdint>

#include "core/base/contact_normals.hpp"
#include "core/base/types.hpp"
#include "core/local_model/local_model.hpp"
#include "core/local_model/patch_proxy.hpp"
#include "core/local_model/prefetched_geometry.hpp"
#include "core/local_model/share_within.hpp"
#include "core/material/contact_law.hpp"

namespace feltwire {

/// The answer of a model at one position.
struct LocalForce {
  Command command;  // on the hand, world frame; no torque
  /// The share of the model's command in the whole. 1: the model is valid here; 0: it gives no
  /// force; between: the tool is about to leave the model's reach.
  double weight = 0.0;
  /// The work was cut off, so the model gives no force now.
  bool cut = false;
};

/// The height of a point above a patch's surface, and the normal there.
struct Height {
  double height = 0.0;         // [m] < 0 in the solid
  Vec3 normal = Vec3::Zero();  // unit; zero where the surface leaves it undefined
};
/// The height above the patch, shifted by `moved` [m]. Precondition: its axis is unit or zero.
Height height_above(const SurfacePatch& patch, const Vec3& moved, const Vec3& point) noexcept;

/// The normals of the patches that push a tool at `point`. Empty if a solid of several joined faces
/// may be among them, because the pushing face is then not known. Precondition as above.
ContactNormals pushing_normals(const LocalModel& model, const Vec3& point) noexcept;

/// Renders the newest model. As long as it follows a surface, it keeps its own contact state
/// (entered face, stick point, slipping) and ignores the older state of the model. No function
/// allocates, throws or reads a clock.
class LocalContact {
 public:
  /// The outer share of a reach or a radius, in which the weight falls linearly to zero.
  static constexpr double kHandOver = feltwire::kHandOver;

  /// Forgets model and contacts, not the whole surfaces.
  void clear() noexcept {
    const PrefetchedSurfaces* surfaces = surfaces_;
    *this = {};
    surfaces_ = surfaces;
  }

  /// The surfaces that are here in full, until the next call; null: none. They outlive that time.
  void use(const PrefetchedSurfaces* surfaces) noexcept;
  const PrefetchedSurfaces* surfaces() const noexcept { return surfaces_; }

  /// Takes a new model. A contact continues if the model still describes its surface; for other
  /// surfaces the state comes from the model. Every force of touch() is finite for all numbers in
  /// the model (PROTOCOL.md, not_finite, says which numbers a receiver accepts). `answered`: the
  /// server's command at the model's center, if known. On rough patches the part of it that comes
  /// from a texture is added to their force, although it is as old as the reply.
  void take(const LocalModel& model, const Command* answered = nullptr) noexcept;

  /// The force on a tool. `age` [s]: of the model's state; moving surfaces are moved on by it, and
  /// damping and viscosity use the velocity relative to them. `elapsed` [s]: since the last call.
  /// If `work` is cut off, the weight is zero, and the contacts begin anew with the model's memory.
  LocalForce touch(const Tool& tool, double age, double elapsed,
                   WorkLimit* work = nullptr) noexcept;

  const LocalModel& model() const { return model_; }
  /// Whether the model means a whole surface that is here.
  bool has_whole() const noexcept;

 private:
  /// The memory of one object; world frame.
  struct Contact {
    std::uint16_t object = 0;
    ContactMemory memory;
    bool adopted = false;      // the memory is the model's, of the time of its state
    double rough_depth = 0.0;  // [m] where it touched a patch with a texture; else 0
    bool whole = false;        // the memory is of the whole surface, in the object's frame
  };
  /// A force that the patches do not contain.
  struct Texture {
    Vec3 force = Vec3::Zero();  // [N]
    double depth = 0.0;         // [m] depth of the tool when the force was felt; 0: none
  };
  Texture texture_of(const Command& answered) const noexcept;
  const SurfacePatch& patch_of(const Contact& contact) const noexcept;
  bool has_whole(const SurfacePatch& patch) const noexcept;
  Command touch_whole(Contact& contact, const SurfacePatch& patch, const Tool& tool,
                      WorkLimit* work) const noexcept;
  void bring_up(Contact& contact, double age, double elapsed) const noexcept;
  const Contact* contact_of(std::uint16_t object) const noexcept;
  Contact continued(const LocalModel& model, std::uint16_t object) const noexcept;
  double weight_at(const Vec3& position) const noexcept;
  Command touch_object(Contact& contact, const Tool& tool, double age, double elapsed,
                       double& weight, WorkLimit* work) const noexcept;
  LocalForce cut_off() noexcept;
  void adopt_whole() noexcept;

  const PrefetchedSurfaces* surfaces_ = nullptr;
  LocalModel model_;  // normals and axes exactly unit
  std::array<Contact, kMaxPatches> contacts_{};
  int count_ = 0;
  Texture texture_;
  CameFrom from_;             // the place of the last touch()
  double last_weight_ = 0.0;  // of the last touch(): 0: the contacts may not be the scene's
};

}  // namespace feltwire
