#pragma once
// The contact with a local model's patches, at whatever rate the hand is asked.

#include <array>
#include <cstdint>

#include "core/base/types.hpp"
#include "core/local_model/local_model.hpp"
#include "core/local_model/patch_proxy.hpp"
#include "core/material/contact_law.hpp"

namespace feltwire {

/// The answer of a model at one position.
struct LocalForce {
  Command command;  // on the hand, world frame; no torque
  /// 1: the model speaks; 0: it says nothing; between: the share of its command in the whole, on
  /// the way out of its reach.
  double weight = 0.0;
};

/// How high a point is above a patch's surface, and the normal there.
struct Height {
  double height = 0.0;         // [m] < 0 in the solid
  Vec3 normal = Vec3::Zero();  // unit; zero where the surface leaves it undefined
};
/// The patch `moved` [m] on. Precondition: its axis is unit or zero.
Height height_above(const SurfacePatch& patch, const Vec3& moved, const Vec3& point) noexcept;

/// Renders the newest model. What is remembered of a contact (entered face, stick point, slipping)
/// is this side's own as long as it follows the surface, however old the model's state is. Nothing
/// here allocates, throws or reads a clock.
class LocalContact {
 public:
  /// Over this last share of a reach or a radius the weight falls linearly to zero.
  static constexpr double kHandOver = 0.25;

  /// Forgets model and contacts.
  void clear() noexcept { *this = {}; }

  /// Another model. Contacts go on with the surfaces that it still describes; what is remembered of
  /// others is the model's own state. Whatever is in it (see PROTOCOL.md, not_finite, for what a
  /// receiver lets pass), no force of touch() is other than finite.
  /// `answered`: the command to the tool at the model's center, if known. What it has beside the
  /// patches where these are rough (a texture) is given with them, as old as it is.
  void take(const LocalModel& model, const Command* answered = nullptr) noexcept;

  /// The force on a tool. `age` [s] of the model's state: moving surfaces have moved on since, and
  /// damping and viscosity are against them. `elapsed` [s] since the last call.
  LocalForce touch(const Tool& tool, double age, double elapsed) noexcept;

  const LocalModel& model() const { return model_; }

 private:
  /// The memory of one object; world frame.
  struct Contact {
    std::uint16_t object = 0;
    ContactMemory memory;
    bool adopted = false;      // the memory is the model's, of the time of its state
    double rough_depth = 0.0;  // [m] where it touched a patch with a texture; else 0
  };
  /// A force that the patches do not have.
  struct Texture {
    Vec3 force = Vec3::Zero();  // [N]
    double depth = 0.0;         // [m] of the tool that it was felt with; 0: none
  };
  Texture texture_of(const Command& answered) const noexcept;
  const SurfacePatch& patch_of(const Contact& contact) const noexcept;
  void bring_up(Contact& contact, double age, double elapsed) const noexcept;
  const Contact* contact_of(std::uint16_t object) const noexcept;
  Contact continued(const LocalModel& model, std::uint16_t object) const noexcept;
  double weight_at(const Vec3& position) const noexcept;
  Command touch_object(Contact& contact, const Tool& tool, double age, double elapsed,
                       double& weight) const noexcept;

  LocalModel model_;  // normals and axes exactly unit
  std::array<Contact, kMaxPatches> contacts_{};
  int count_ = 0;
  Texture texture_;
  CameFrom from_;             // where touch() was asked last
  double last_weight_ = 0.0;  // of the last touch(): 0: the contacts may not be the scene's
};

}  // namespace feltwire
