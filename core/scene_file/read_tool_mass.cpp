#include "core/scene_file/read_tool_mass.hpp"

#include <cmath>

#include "core/dynamics/mass_properties.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene_file/read_values.hpp"

namespace feltwire {
namespace {

constexpr double kLeastMass = 1e-6, kLargestMass = 1e3;        // [kg] limits for a hand-held tool
constexpr double kLeastDensity = 1e-3, kLargestDensity = 1e6;  // [kg/m^3]

void require_within(const JsonDocument& document, const std::string& field, double value,
                    double least, double most, const char* unit) {
  if (value >= least && value <= most) return;
  document.fail(field, "must be " + number_text(least) + " to " + number_text(most) + " " + unit +
                           ", is " + number_text(value) +
                           "; give it in SI units, or leave it out for a tool without mass");
}

/// Reads the damping [N s/m] and the rotational damping [N m s/rad] of the coupling.
void read_damping(const JsonDocument& document, const std::string& path,
                  const scene_file::ToolCoupling& coupling, ToolInertia& inertia) {
  require(document, path,
          first({not_negative("damping", coupling.damping(), kMaxDamping, " [N s/m]"),
                 not_negative("rotational_damping", coupling.rotational_damping(), kMaxDamping,
                              " [N m s/rad]")}));
  inertia.damping = coupling.damping();
  inertia.rotational_damping = coupling.rotational_damping();
}

MassProperties solid_of(const JsonDocument& document, const std::string& field,
                        const std::optional<Shape>& shape, const TriangleSoup& surface) {
  if (shape) return mass_properties(*shape);
  const TriangleMesh mesh(surface, {}, true);
  if (!mesh.report().closed() || !(mesh.report().volume > 0.0))
    document.fail(
        field,
        "the mesh is no solid, so nothing has this mass: it is open, or its normals point "
        "inwards; close it, or leave mass and density out");
  return mass_properties(mesh);
}

}  // namespace

ToolInertia read_tool_mass(const JsonDocument& document, const std::string& path,
                           const scene_file::ToolBody& body, const scene_file::Scene& scene,
                           const std::optional<Shape>& shape, const TriangleSoup& surface,
                           const Pose& place) {
  ToolInertia inertia;
  if (const auto* coupling = body.coupling())
    read_damping(document, path + ".coupling", *coupling, inertia);
  const bool by_mass = document.has(path + ".mass"), by_density = document.has(path + ".density");
  if (by_mass && by_density)
    document.fail(path + ".density", "stands beside a mass; keep one of the two");
  if (!by_mass && !by_density) {
    for (const char* field : {".integration", ".coupling.damping", ".coupling.rotational_damping"})
      if (document.has(path + field))
        document.fail(path + field,
                      "is of a tool with mass, which this one has not; give its mass [kg] or "
                      "density [kg/m^3], or remove this");
    return {};
  }
  const std::string field = path + (by_mass ? ".mass" : ".density");
  if (by_mass)
    require_within(document, field, body.mass(), kLeastMass, kLargestMass, "[kg]");
  else
    require_within(document, field, body.density(), kLeastDensity, kLargestDensity, "[kg/m^3]");
  const MassProperties solid = placed(solid_of(document, field, shape, surface), place);
  const double density = by_mass ? body.mass() / solid.volume : body.density();
  inertia.mass = density * solid.volume;
  require_within(document, field, inertia.mass, kLeastMass, kLargestMass,
                 by_mass ? "[kg]" : "[kg] of the whole tool");
  inertia.center = solid.center;
  inertia.inertia = density * solid.inertia;
  inertia.gravity = MechanismOptions{}.gravity;
  if (const auto* gravity = scene.gravity()) inertia.gravity = vector(*gravity);
  if (body.integration() == scene_file::Integration::midpoint)
    inertia.integration = ToolIntegration::midpoint;
  return inertia;
}

}  // namespace feltwire
