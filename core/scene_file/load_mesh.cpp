#include "core/scene_file/load_mesh.hpp"

#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/written_number.hpp"
#include "core/mesh/height_map.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/thin_solid.hpp"
#include "core/scene_file/read_parts.hpp"
#include "core/scene_file/read_values.hpp"
#include "core/scene_file/shown_error.hpp"

namespace feltwire {
namespace {

struct Unit {
  const char* name;
  double metres;
};
constexpr std::array<Unit, 6> kUnits = {
    {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048}}};

std::string rounded(double value) { return printed("%.3g", value); }

double scale_of(const JsonDocument& document, const std::string& path,
                const scene_file::Mesh& mesh) {
  const bool scaled = !std::isnan(mesh.scale());
  if (scaled == (mesh.unit() != nullptr))
    document.fail(path + (scaled ? ".unit" : ".scale"),
                  "give either scale [m per unit of the file] or unit (m, cm, mm, um, in, ft)");
  if (scaled) {
    if (!(mesh.scale() > 0.0 && mesh.scale() <= kMaxLength))
      document.fail(path + ".scale", "must be above zero and at most " + number_text(kMaxLength) +
                                         ", is " + number_text(mesh.scale()) + "; check the unit");
    return mesh.scale();
  }
  for (const Unit& unit : kUnits)
    if (mesh.unit()->str() == unit.name) return unit.metres;
  document.fail(path + ".unit",
                "must be one of: m, cm, mm, um, in, ft; is '" + mesh.unit()->str() + "'");
}

MeshOptions options_of(const JsonDocument& document, const std::string& path,
                       const scene_file::Mesh& mesh) {
  MeshOptions options{.double_sided = mesh.double_sided(),
                      .smooth = mesh.smooth(),
                      .radius = mesh.radius(),
                      .grain = {}};
  if (!(options.radius >= 0.0 && options.radius <= kMaxLength))
    document.fail(path + ".radius",
                  "must be at least zero [m], is " + number_text(options.radius) + "; correct it");
  if (const auto* grain = mesh.grain()) {
    options.grain = {grain->amplitude(), grain->wavelength()};
    for (const auto& [field, value] : {std::pair("amplitude", options.grain.amplitude),
                                       std::pair("wavelength", options.grain.wavelength)})
      require(document, path + ".grain", positive(field, value, kMaxLength, " [m]"));
  }
  return options;
}

/// Returns the given weld distance [m], or nothing to use the default of the mesh.
std::optional<double> weld_of(const JsonDocument& document, const std::string& path,
                              const scene_file::Mesh& mesh) {
  if (std::isnan(mesh.weld())) return std::nullopt;
  require(document, path, not_negative("weld", mesh.weld(), kMaxLength, " [m]"));
  return mesh.weld();
}

std::shared_ptr<const HeightMap> height_map_of(const JsonDocument& document,
                                               const std::string& path,
                                               const std::filesystem::path& folder,
                                               const scene_file::HeightMap& map) {
  require(document, path,
          first({positive("amplitude", map.amplitude(), kMaxLength, " [m]"),
                 positive("size", map.size(), kMaxLength, " [m]")}));
  const std::string name = map.file()->str();
  if (name.empty() || name.find('\0') != std::string::npos)
    document.fail(path + ".file", "names no file; give the path of a .pgm file");
  const std::filesystem::path file = folder / name;
  try {
    return std::make_shared<HeightMap>(parse_pgm(read_text(file), file.string()), map.amplitude(),
                                       map.size());
  } catch (const FileError& error) {
    document.fail(path + ".file", shown_error(error.what(), file, folder));
  }
}

}  // namespace

std::optional<std::string> odd_size(const std::string& name, double size, double scale) {
  // [m] Outside these limits, the unit is probably wrong.
  constexpr double kLargest = 20.0, kLeast = 1e-4;
  constexpr double kUsualLeast = 5e-3, kUsual = 3.0;  // [m] usual sizes
  if (size <= kLargest && size >= kLeast) return std::nullopt;
  std::string others;
  for (const Unit& unit : kUnits) {
    const double then = size / scale * unit.metres;
    if (then < kUsualLeast || then > kUsual) continue;
    others += (others.empty() ? "" : ", or ") + number_text(unit.metres) + " if its file is in " +
              unit.name + " (then it is " + rounded(then) + " m)";
  }
  return name + ": is " + rounded(size) + " m large with a scale of " + number_text(scale) +
         (others.empty() ? "; check its unit" : "; give a scale of " + others);
}

Mesh MeshLoader::load(const std::string& path, const scene_file::Mesh& mesh, bool moves) {
  const bool solid = moves || solids_ || mesh.closed();
  const double scale = scale_of(document_, path, mesh);
  MeshOptions options = options_of(document_, path, mesh);
  const std::optional<double> weld = weld_of(document_, path, mesh);
  const std::string name = mesh.file()->str();
  if (name.empty() || name.find('\0') != std::string::npos)
    document_.fail(path + ".file", "names no file; give the path of an .obj, .stl or .ply file");
  const auto* map = mesh.height_map();
  const std::string key =
      name + '\n' + number_text(scale) + '\n' + number_text(options.radius) +
      (options.double_sided ? "d" : "s") + (options.smooth ? "i" : "f") +
      (mesh.closed() ? "c" : "o") + (solid ? "s" : "f") + number_text(mesh.weld()) + "/" +
      number_text(options.grain.amplitude) + "/" + number_text(options.grain.wavelength) + "\n" +
      (map != nullptr ? map->file()->str() + '\n' + number_text(map->amplitude()) + "/" +
                            number_text(map->size())
                      : "");
  if (const auto at = known_.find(key); at != known_.end()) {
    read_parts_options(document_, path, mesh, *at->second.surface);
    return at->second;
  }
  if (map != nullptr)
    options.height_map = height_map_of(document_, path + ".height_map", folder_, *map);
  try {
    TriangleMesh triangles(read_scene_mesh(folder_, name, scale), weld, solid);
    const MeshReport& report = triangles.report();
    if (mesh.closed() && !report.closed())
      document_.fail(path + ".closed", name + " is not closed: " + open_text(report) + "; " +
                                           mend_text(report) + ", or leave closed out");
    for (const std::string& warning : feltwire::warnings(report, !options.double_sided))
      warnings_.push_back(name + ": " + warning);
    if (auto odd = odd_size(name, report.size, scale)) warnings_.push_back(std::move(*odd));
    if (report.closed() && report.volume < 0.0 && !options.double_sided) {
      triangles.turn();
      warnings_.push_back(name + ": its normals look inwards; the surface was turned");
    }
    Mesh made{std::make_shared<MeshSurface>(std::move(triangles), options)};
    if (const auto thin = warning_of_thin_solid(*made.surface); thin && !options.double_sided)
      warnings_.push_back(name + ": " + *thin);
    if (const auto violation = check(Shape(made)))
      document_.fail(path + "." + violation->field, violation->message);
    read_parts_options(document_, path, mesh, *made.surface);
    known_.emplace(key, made);
    return made;
  } catch (const FileError& error) {
    // An error about the mesh file already names the file and the line.
    if (std::string(error.what()).starts_with((folder_ / name).string()))
      document_.fail(path + ".file", error.what());
    throw;
  } catch (const std::bad_alloc&) {
    document_.fail(path + ".file", name + " does not fit into the memory; simplify the surface");
  } catch (const std::exception& error) {
    document_.fail(path + ".file", name + ": " + error.what());
  }
}

}  // namespace feltwire
