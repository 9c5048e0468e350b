// Takes arbitrary bytes as a mesh file of each format. The result must be an error with its place,
// or a surface. The surface must be complete, give finite forces, and let no hand through a
// triangle.
//   byte 0   format and scale
//   byte 1   weld distance and touched side
//   the rest the file

#include "core/base/splitmix.hpp"
#include "core/contact/contact.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr std::size_t kMostTriangles = 400;  // The test checks each triangle.

void require_soup(const TriangleSoup& soup) {
  require(!soup.triangles.empty(), "a surface has triangles");
  for (const Vec3& v : soup.vertices)
    require(v.cwiseAbs().maxCoeff() <= 1e6 * (1 + 1e-12), "vertices lie in the world");
  for (const Triangle& t : soup.triangles)
    for (const std::uint32_t i : t) require(i < soup.vertices.size(), "corners have a vertex");
}

void require_mesh(const TriangleMesh& mesh, const TriangleSoup& soup) {
  const MeshReport& report = mesh.report();
  require(mesh.triangles().size() + report.degenerate + report.duplicate ==
              soup.triangles.size() + report.split.added,
          "every triangle is kept or split, without an area or a duplicate");
  require(report.joined == 0 || report.joined_farthest <= report.weld, "none is joined from afar");
  require((report.holes.count > 0) == (report.boundary_edges > 0), "open edges are rims of holes");
  require(std::isfinite(report.holes.widest) && report.holes.narrowest <= report.holes.widest,
          "holes have a width");
  require(std::isfinite(report.volume), "the volume is finite");
  std::size_t open = 0;
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.neighbour(t, k);
      open += other == TriangleMesh::kNone ? 1 : 0;
      if (other == TriangleMesh::kNone) continue;
      bool back = false;
      for (int j = 0; j < 3; ++j) back = back || mesh.neighbour(other, j) == t;
      require(back, "a neighbour has this triangle for its own");
    }
  require(report.closed() == (open == 0), "a closed surface has no edge without a neighbour");
  for (std::uint32_t v = 0; v < mesh.vertices().size(); ++v)
    require(!mesh.around(v).empty(), "every vertex is a triangle's");
}

/// A path through the middle of a triangle must hit it, or another triangle before. The triangle is
/// not degenerate.
void require_holds(const MeshSurface& surface, std::uint32_t t) {
  const std::array<Vec3, 3> c = surface.mesh().corners(t);
  const double longest =
      std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
  const double height = (c[1] - c[0]).cross(c[2] - c[0]).norm() / longest;
  const double size = surface.mesh().half_extents().maxCoeff();
  if (!(height > 1e-3 * longest && height > 1e-6 * size && size > 1e-100)) return;
  const Vec3 middle = (c[0] + c[1] + c[2]) / 3.0, normal = triangle_normal(c);
  require(surface.first_crossing(middle + 0.1 * height * normal, middle - 0.1 * height * normal, 1)
              .has_value(),
          "no way leads through a triangle");
}

void require_felt(const std::shared_ptr<const MeshSurface>& surface) {
  const TriangleMesh& mesh = surface->mesh();
  Object object;
  object.name = "mesh";
  object.shape = Mesh{surface};
  ContactMemory memory;
  std::uint64_t i = 0;
  const auto draw = [&] {
    return 2.0 * 0x1p-53 * static_cast<double>(splitmix::draw(1, i++) >> 11) - 1.0;
  };
  for (int n = 0; n < 64; ++n) {
    const Vec3 part(draw(), draw(), draw());
    const Command felt =
        touch(object, {mesh.origin() + 1.1 * mesh.half_extents().cwiseProduct(part), Vec3::Zero()},
              memory);
    require(felt.finite(), "every touch is answered with a finite force");
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  fuzz::Input input(data, size);
  const std::uint8_t how = input.byte(), felt = input.byte();
  constexpr std::array<const char*, 3> kNames = {"mesh.obj", "mesh.stl", "mesh.ply"};
  constexpr std::array<double, 4> kScales = {1.0, 1e-3, 0.0254, 1e6};
  const std::string name = kNames[how % kNames.size()];
  const double scale = kScales[how / 3 % kScales.size()];
  const Bytes rest = input.bytes(input.size());
  const std::string bytes = fuzz::text(rest.data(), rest.size());
  TriangleSoup soup;
  try {
    soup = parse_mesh(bytes, name, scale);
  } catch (const FileError& error) {
    const std::string_view message = error.what();
    fuzz::require(message.starts_with(name + ":"), "an error names its file");
    return 0;
  }
  fuzz::require_soup(soup);
  try {
    const std::optional<double> weld =
        (felt & 1) != 0 ? std::optional<double>((felt & 2) != 0 ? 0.0 : 1e-2) : std::nullopt;
    TriangleMesh mesh(soup, weld);
    fuzz::require_mesh(mesh, soup);
    warnings(mesh.report(), true);
    const MeshOptions options{.double_sided = (felt & 4) != 0,
                              .smooth = (felt & 8) != 0,
                              .radius = (felt & 16) != 0 ? 1e-3 : 0.0};
    const auto surface = std::make_shared<const MeshSurface>(std::move(mesh), options);
    const std::size_t looked = std::min(surface->mesh().triangles().size(), fuzz::kMostTriangles);
    for (std::uint32_t t = 0; t < looked; ++t) fuzz::require_holds(*surface, t);
    fuzz::require_felt(surface);
  } catch (const std::invalid_argument& error) {
    fuzz::require(std::string_view(error.what()).starts_with("mesh: "), "an error names the mesh");
  }
  return 0;
}
