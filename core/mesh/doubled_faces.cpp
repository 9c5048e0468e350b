#include "core/mesh/doubled_faces.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/mesh/bucketed.hpp"

namespace feltwire::doubled_faces {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A face: three corners in ascending order, and the first triangle in each direction. A forward
/// triangle lists the corners in this cyclic order, and a backward triangle in the opposite order.
struct Face {
  Triangle corners;
  std::uint32_t first = kNone;                      // first triangle of the face
  std::array<std::uint32_t, 2> side{kNone, kNone};  // forward and backward triangle, or kNone
  bool has_both() const { return side[0] != kNone && side[1] != kNone; }
};

bool is_forward(const Triangle& t) {
  const std::size_t low =
      static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
  return t[corner_after(low)] < t[corner_after(corner_after(low))];
}

/// The corners of a triangle, in ascending order.
struct Corners {
  std::uint32_t low, middle, high, triangle;
  bool operator==(const Corners& other) const {
    return low == other.low && middle == other.middle && high == other.high;
  }
};

/// Returns the corners of all triangles, sorted by the lowest corner, then by the other two.
std::vector<Corners> sorted_corners(std::span<const Triangle> triangles, std::size_t vertices) {
  return bucketed<Corners>(
      triangles.size(), vertices,
      [&](std::size_t t) {
        Triangle c = triangles[t];
        std::sort(c.begin(), c.end());
        return Corners{c[0], c[1], c[2], static_cast<std::uint32_t>(t)};
      },
      [](const Corners& x, const Corners& y) {
        return std::tie(x.middle, x.high, x.triangle) < std::tie(y.middle, y.high, y.triangle);
      });
}

std::vector<Face> faces_of(std::span<const Triangle> triangles, std::span<const Corners> all) {
  std::vector<Face> faces;
  for (const Corners& c : all) {
    const Triangle corners{c.low, c.middle, c.high};
    if (faces.empty() || faces.back().corners != corners)
      faces.push_back({.corners = corners, .first = c.triangle});
    std::uint32_t& side = faces.back().side[is_forward(triangles[c.triangle]) ? 0 : 1];
    if (side == kNone) side = c.triangle;
  }
  return faces;
}

/// An edge of a face. `way` is 1 if a forward triangle of the face runs from the lower to the
/// higher vertex of the edge, else -1.
struct EdgeOfFace {
  std::uint32_t low, high, face;
  int way;
};

/// Returns the edges between corners of faces that have triangles in both directions. Lists all
/// faces of each edge, sorted by edge.
std::vector<EdgeOfFace> edges_in_question(const std::vector<Face>& faces, std::size_t vertices) {
  std::vector<bool> asked(vertices);
  for (const Face& face : faces)
    if (face.has_both())
      for (const std::uint32_t v : face.corners) asked[v] = true;
  std::vector<EdgeOfFace> edges;
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const Triangle& c = faces[f].corners;
    for (const auto& [a, b, way] : {std::tuple(0, 1, 1), std::tuple(1, 2, 1), std::tuple(0, 2, -1)})
      if (asked[c[static_cast<std::size_t>(a)]] && asked[c[static_cast<std::size_t>(b)]])
        edges.push_back({c[static_cast<std::size_t>(a)], c[static_cast<std::size_t>(b)], f, way});
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeOfFace& a, const EdgeOfFace& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  return edges;
}

/// Groups of faces whose choices depend on each other (union-find with signs). The choice of a face
/// is the direction to keep. It equals the choice of the group, or is opposite.
class Groups {
 public:
  explicit Groups(std::size_t faces)
      : parent_(faces), sign_(faces, 1), torn_(faces), links_(faces) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  struct Place {
    std::uint32_t group;
    int sign;  // product of the choices of the face and of its group
  };
  Place find(std::uint32_t face) {
    std::uint32_t root = face;
    int sign = 1;
    while (parent_[root] != root) {
      sign *= sign_[root];
      root = parent_[root];
    }
    const Place place{root, sign};
    while (parent_[face] != face) {  // path compression
      const std::uint32_t next = parent_[face];
      const int own = sign_[face];
      parent_[face] = root;
      sign_[face] = sign;
      sign *= own;
      face = next;
    }
    return place;
  }

  /// Requires that the product of the two choices is `product`.
  void link(std::uint32_t a, std::uint32_t b, int product) {
    Place one = find(a), other = find(b);
    if (one.group == other.group) {
      if (one.sign * other.sign != product) torn_[one.group] = true;
    } else {
      if (other.group < one.group) std::swap(one, other);
      parent_[other.group] = one.group;
      sign_[other.group] = one.sign * other.sign * product;
      if (torn_[other.group]) torn_[one.group] = true;
      links_[one.group] += links_[other.group];
    }
    ++links_[one.group];
  }

  /// Returns true if the links of the group contradict each other, as on a Moebius strip.
  bool is_torn(std::uint32_t group) const { return torn_[group]; }
  std::size_t links(std::uint32_t group) const { return links_[group]; }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<int> sign_;  // product of the face's and its parent's choice
  std::vector<bool> torn_;
  std::vector<std::size_t> links_;
};

class Choice {
 public:
  Choice(std::span<const Vec3> vertices, const std::vector<Face>& faces)
      : vertices_(vertices), faces_(faces), edges_(edges_in_question(faces, vertices.size())) {
    chosen_.reserve(faces.size());
    for (const Face& face : faces)
      chosen_.push_back(face.has_both() ? 0 : face.side[0] != kNone ? 1 : -1);
  }

  /// Decides the faces that have decided neighbours. Works in rounds, because each decision may
  /// decide further faces at a shared edge.
  void ask_neighbours() {
    constexpr int kMostRounds = 16;
    for (int round = 0; round < kMostRounds; ++round) {
      Groups groups(faces_.size());
      const std::vector<long> votes = count_votes(groups);
      bool decided = false;
      for (std::uint32_t f = 0; f < faces_.size(); ++f) {
        if (chosen_[f] != 0) continue;
        const Groups::Place place = groups.find(f);
        const long vote = votes[place.group];
        if (vote == 0 || groups.is_torn(place.group)) continue;
        chosen_[f] = vote > 0 ? place.sign : -place.sign;
        decided = true;
      }
      if (!decided) return;
    }
  }

  /// Orients each closed shell that is still undecided so that its volume is positive.
  void turn_shells_outwards() {
    Groups groups(faces_.size());
    count_votes(groups);
    std::vector<double> volume(faces_.size());
    std::vector<std::size_t> count(faces_.size());
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (chosen_[f] != 0) continue;
      const Groups::Place place = groups.find(f);
      const Triangle& c = faces_[f].corners;
      volume[place.group] +=
          place.sign * vertices_[c[0]].dot(vertices_[c[1]].cross(vertices_[c[2]]));
      ++count[place.group];
    }
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (chosen_[f] != 0) continue;
      const auto [group, sign] = groups.find(f);
      // In a closed shell, each edge links two faces, so 2 * edges = 3 * faces.
      if (groups.is_torn(group) || 2 * groups.links(group) != 3 * count[group]) continue;
      if (volume[group] != 0.0) chosen_[f] = volume[group] > 0.0 ? sign : -sign;
    }
  }

  /// Returns the chosen direction of the face: 1 forward, -1 backward, 0 both.
  int of(std::size_t face) const { return chosen_[face]; }

 private:
  /// Links the undecided faces. Counts the votes of the decided neighbours for each group.
  std::vector<long> count_votes(Groups& groups) const {
    std::vector<std::pair<std::uint32_t, long>> own;  // undecided faces and their votes
    for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
      int open = 0,
          up = 0;  // open: number of undecided faces; up: sum of the decided directions
      for (; end < edges_.size() && edges_[end].low == edges_[begin].low &&
             edges_[end].high == edges_[begin].high;
           ++end) {
        const int chosen = chosen_[edges_[end].face];
        open += chosen == 0 ? 1 : 0;
        up += chosen * edges_[end].way;
      }
      // Two neighbours agree if they traverse their common edge in opposite directions.
      const EdgeOfFace &one = edges_[begin], &last = edges_[end - 1];
      if (open == 2 && end - begin == 2) groups.link(one.face, last.face, -one.way * last.way);
      if (open != 1 || up == 0) continue;
      for (std::size_t i = begin; i < end; ++i)
        if (chosen_[edges_[i].face] == 0)
          own.emplace_back(edges_[i].face, up > 0 ? -edges_[i].way : edges_[i].way);
    }
    std::vector<long> votes(faces_.size());
    for (const auto& [face, vote] : own) {
      const Groups::Place place = groups.find(face);
      votes[place.group] += place.sign * vote;
    }
    return votes;
  }

  std::span<const Vec3> vertices_;
  const std::vector<Face>& faces_;
  std::vector<EdgeOfFace> edges_;
  std::vector<int> chosen_;
};

}  // namespace

KeptFaces keep_one_of_each(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                           bool solid) {
  KeptFaces kept;
  std::vector<Corners> all = sorted_corners(triangles, vertices.size());
  if (std::ranges::adjacent_find(all) == all.end()) return kept;
  const std::vector<Face> faces = faces_of(triangles, all);
  std::vector<Corners>().swap(all);  // Free memory, because the surface may be large.
  Choice choice(vertices, faces);
  choice.ask_neighbours();
  if (solid) choice.turn_shells_outwards();

  std::vector<std::uint32_t> face_at(triangles.size(), kNone);
  for (std::uint32_t f = 0; f < faces.size(); ++f) face_at[faces[f].first] = f;
  kept.triangles.reserve(faces.size());
  for (const std::uint32_t f : face_at) {
    if (f == kNone) continue;
    const Face& face = faces[f];
    const int chosen = choice.of(f);
    if (chosen >= 0) kept.triangles.push_back(triangles[face.side[0]]);
    if (chosen <= 0) kept.triangles.push_back(triangles[face.side[1]]);
    if (face.has_both()) ++(chosen == 0 ? kept.both_sides : kept.opposed);
  }
  kept.same = triangles.size() - kept.triangles.size() - kept.opposed;
  return kept;
}

}  // namespace feltwire::doubled_faces
