// Messages to the user about defects of a surface.

#include <string>
#include <vector>

#include "core/base/written_number.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {
namespace {

std::string metres(double length) { return printed("%.3g m", length); }

}  // namespace

std::string holes_text(const MeshReport& report) {
  if (report.holes.count == 0) return "";
  if (report.holes.count == 1) return ", 1 hole " + metres(report.holes.widest) + " across";
  return ", " + std::to_string(report.holes.count) + " holes " + metres(report.holes.narrowest) +
         " to " + metres(report.holes.widest) + " across";
}

std::string open_text(const MeshReport& report) {
  return std::to_string(report.boundary_edges) + " open edges" + holes_text(report) + ", " +
         std::to_string(report.non_manifold_edges) + " with more than two triangles, " +
         std::to_string(report.turned_edges) + " between triangles turned against each other";
}

std::string mend_text(const MeshReport& report) {
  // Largest width of a narrow hole, as a share of the longest side.
  constexpr double kNarrow = 1e-3;
  if (report.holes.count == 0 || report.holes.widest > kNarrow * report.size) return "mend it";
  return "set \"weld\": " + printed("%.2g", 2.0 * report.holes.widest) +
         ", which closes narrow holes, or mend it";
}

std::vector<std::string> warnings(const MeshReport& report, bool closed) {
  std::vector<std::string> found;
  const auto say = [&](std::size_t count, const std::string& what) {
    if (count > 0) found.push_back(std::to_string(count) + what);
  };
  say(report.joined, " vertices of open edges were joined with one that is at most " +
                         metres(report.weld) + " away; the farthest was " +
                         metres(report.joined_farthest) + " away");
  say(report.degenerate, " triangles have no area and were left out; " +
                             (report.degenerate_height > 0.0
                                  ? "the highest is " + metres(report.degenerate_height) + " high"
                                  : std::string("nothing is missing of the surface")));
  say(report.split.count, " open edges had corners of other triangles on them, at most " +
                              metres(report.split.farthest) +
                              " away, and were split there; the surface is the same");
  if (report.split.search_ended)
    found.push_back(
        "too many open edges lie over each other to look at all for corners on them; remove what "
        "stands twice");
  say(report.duplicate - report.opposed, " triangles stand twice; one of each was left out");
  say(report.opposed,
      " triangles stand twice, once turned over; the one that agrees with its neighbours was kept, "
      "the other would have let a hand through");
  say(report.both_sides,
      " triangles stand twice, once turned over, and no neighbour decides which is right: they are "
      "felt from both sides; remove the one that looks inwards, or set closed if they bound a "
      "solid");
  say(report.non_manifold_edges, " edges have more than two triangles; the hand is slower there");
  say(report.turned_edges,
      " edges lie between triangles that disagree about the outside; unify the normals");
  if (closed)
    say(report.boundary_edges, " edges have one triangle: the surface has holes" +
                                   holes_text(report) + "; " + mend_text(report) +
                                   ", or set double_sided");
  constexpr std::size_t kCrowd = 1000;
  if (report.most_at_corner > kCrowd)
    found.push_back(std::to_string(report.most_at_corner) +
                    " triangles meet at one corner; the hand is slower there, cut the face with so "
                    "many corners into smaller ones");
  if (report.typical_side < TriangleMesh::kWeld * report.size)
    found.push_back("the surface is " + metres(report.size) + " large, its triangles are " +
                    metres(report.typical_side) +
                    ": a vertex lies far away from the others, and details are lost; remove it");
  return found;
}

}  // namespace feltwire
