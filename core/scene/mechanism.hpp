#pragma once
// The moving part of a scene: bodies, their joints, and the MuJoCo model compiled from them.

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/scene/validation.hpp"

struct mjModel_;

namespace feltwire {

enum class Joint : std::uint8_t { free, hinge, slide };

/// A rigid body. One or more objects are its surface.
struct Body {
  std::string name;
  Pose pose;  // at the start, world frame; hinge and slide pass through the position
  Joint joint = Joint::free;
  // Exactly one of mass and density is given. Where objects overlap, the volume counts twice.
  std::optional<double> mass;     // [kg], > 0, spread evenly over the objects' volume
  std::optional<double> density;  // [kg/m^3], > 0
  bool collides = true;  // with other bodies and static objects; hands feel it in both cases

  // Only for hinge [rad] and slide [m]. At 0 the body has the pose above.
  Vec3 axis = Vec3::UnitZ();  // own frame
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  double stiffness = 0.0;  // [N/m], [N m/rad] of a spring, >= 0
  double rest = 0.0;       // [m], [rad] position of the spring without force
  double damping = 0.0;    // [N s/m], [N m s/rad], >= 0
  double friction = 0.0;   // [N], [N m] dry friction of the joint, >= 0
};

/// Returns the first rule that is broken, if any. Fields are named as in a scene file.
std::optional<Violation> check(const Body& body);

inline constexpr double kDefaultTick = 1e-3;  // [s]
inline constexpr double kLeastTick = 1e-4, kLargestTick = 1e-2;

struct MechanismOptions {
  Vec3 gravity{0.0, 0.0, -9.81};  // [m/s^2]
  double tick = kDefaultTick;     // [s] of simulated time a step
};
std::optional<Violation> check(const MechanismOptions& options);

/// The moving part of a scene. Immutable; a World is one run of it.
class Mechanism {
 public:
  /// An object that moves with a body.
  struct Part {
    int body = 0;  // MuJoCo's number
    Pose in_body;  // of the object
  };

  /// `start`: MuJoCo's coordinates (qpos) at the start; empty: those of the model (qpos0).
  Mechanism(std::shared_ptr<const mjModel_> model, std::size_t still, std::vector<Part> parts,
            std::vector<std::string> warnings, std::vector<double> start = {})
      : model_(std::move(model)),
        still_(still),
        parts_(std::move(parts)),
        warnings_(std::move(warnings)),
        start_(std::move(start)) {}

  const mjModel_& model() const { return *model_; }
  const std::vector<double>& start() const { return start_; }
  /// The objects of a scene are `still()` static ones, followed by one for each part.
  std::size_t still() const { return still_; }
  const std::vector<Part>& parts() const { return parts_; }
  /// Warnings about values that are valid but look like mistakes. One line each, with the remedy.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::shared_ptr<const mjModel_> model_;
  std::size_t still_;
  std::vector<Part> parts_;
  std::vector<std::string> warnings_;
  std::vector<double> start_;
};

}  // namespace feltwire
