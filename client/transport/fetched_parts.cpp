#include "client/transport/fetched_parts.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "client/transport/fetch_room.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {
namespace {

bool near(const Vec3& v) { return v.cwiseAbs().maxCoeff() <= kMaxPosition && v.allFinite(); }

bool plausible(const Pose& pose) {
  return near(pose.position) && std::abs(pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
}

/// Returns whether the numbers of a surface are valid. NaN is invalid.
bool plausible(const SurfaceData& s) {
  return plausible(s.pose) && near(s.origin) && s.radius >= 0.0 && s.radius <= kMaxPosition &&
         s.grain >= 0.0 && s.grain <= kMaxPosition && s.grain_wavelength > 0.0 &&
         std::isfinite(s.grain_wavelength);
}

bool plausible(const SolidData& s) { return plausible(s.pose); }

std::string object_text(std::uint16_t object) { return "object " + std::to_string(object); }

/// Refuses the answer unless the object numbers increase. `next`: lowest allowed number.
void require_rising(const ControlDialogue& dialogue, std::uint16_t object, std::uint32_t& next) {
  if (object < next)
    dialogue.refuse("listed " + object_text(object) + " of the scene twice, or not in order");
  next = std::uint32_t{object} + 1;
}

void require_near(const ControlDialogue& dialogue, const std::vector<Vec3>& places) {
  if (!std::ranges::all_of(places, near))
    dialogue.refuse("sent a point of the scene that is no number, or is beyond 1000 m");
}

/// Collects a list that arrives in parts, and checks its announced size. `entries`: name of the
/// entries in error messages.
template <class Entry>
class Parts {
 public:
  Parts(const ControlDialogue& dialogue, const char* entries, std::uint32_t announced)
      : dialogue_(dialogue), entries_(entries), announced_(announced) {}

  bool whole() const { return had_.size() == announced_; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(had_.size()); }
  void add(const std::vector<Entry>& part, const std::string& whose) {
    if (part.size() > announced_ - had_.size())
      dialogue_.refuse("sent more " + std::string(entries_) + " of " + whose + " than the " +
                       std::to_string(announced_) + " that it had announced");
    had_.insert(had_.end(), part.begin(), part.end());
  }
  std::vector<Entry> take() { return std::move(had_); }

 private:
  const ControlDialogue& dialogue_;
  const char* entries_;
  std::uint32_t announced_;
  std::vector<Entry> had_;
};

[[noreturn]] void refuse_empty(const ControlDialogue& dialogue, const std::string& whose) {
  dialogue.refuse("sent an empty part of " + whose + ", of which there is more");
}

TriangleSoup fetched_mesh(ControlDialogue& dialogue, std::uint64_t session, std::uint32_t version,
                          std::uint16_t object, std::uint32_t vertices, std::uint32_t triangles) {
  Parts<Vec3> places(dialogue, "vertices", vertices);
  Parts<Triangle> corners(dialogue, "triangles", triangles);
  while (!places.whole() || !corners.whole()) {
    const auto part = dialogue.ask_for<control::SurfacePart>(
        control::GetSurface{session, version, object, places.count(), corners.count()});
    if (part.vertices.empty() && part.triangles.empty())
      refuse_empty(dialogue, object_text(object));
    require_near(dialogue, part.vertices);
    places.add(part.vertices, object_text(object));
    corners.add(part.triangles, object_text(object));
  }
  return {places.take(), corners.take()};
}

void give_mesh(SurfaceData& surface, TriangleSoup mesh) {
  surface.vertices = std::move(mesh.vertices);
  surface.triangles = std::move(mesh.triangles);
}

void give_mesh(SolidData& solid, TriangleSoup mesh) { solid.mesh = std::move(mesh); }

/// Fetches the things (surfaces or solids) of a list in order, each with its mesh. Skips a thing if
/// FetchRoom::*take has no room for it. `thing`: member of an entry that contains the thing.
template <class Thing, class Entry>
std::vector<Thing> fetched_things(ControlDialogue& dialogue, std::uint64_t session,
                                  std::uint32_t version, const std::vector<Entry>& list,
                                  Thing Entry::*thing,
                                  bool (FetchRoom::*take)(std::uint32_t, std::uint32_t) noexcept) {
  std::vector<Thing> things;
  FetchRoom room;
  std::uint32_t next = 0;
  for (const Entry& entry : list) {
    const Thing& listed = entry.*thing;
    require_rising(dialogue, listed.object, next);
    if (!(room.*take)(entry.vertices, entry.triangles)) continue;
    if (!plausible(listed))
      dialogue.refuse("listed " + object_text(listed.object) +
                      " with a number that no object can have");
    give_mesh(things.emplace_back(listed), fetched_mesh(dialogue, session, version, listed.object,
                                                        entry.vertices, entry.triangles));
  }
  return things;
}

}  // namespace

std::vector<SurfaceData> fetched_surfaces(ControlDialogue& dialogue, std::uint64_t session,
                                          const control::SurfaceList& list) {
  return fetched_things(dialogue, session, list.version, list.surfaces,
                        &control::SurfaceEntry::surface, &FetchRoom::take_surface);
}

std::vector<SolidData> fetched_solids(ControlDialogue& dialogue, std::uint64_t session,
                                      const control::SolidList& list) {
  return fetched_things(dialogue, session, list.version, list.solids, &control::SolidEntry::solid,
                        &FetchRoom::take_solid);
}

BodyData fetched_body(ControlDialogue& dialogue, std::uint64_t session,
                      const control::SolidList& list) {
  BodyData body = *list.body;
  Parts<Vec3> points(dialogue, "points", list.points);
  while (!points.whole()) {
    const auto part = dialogue.ask_for<control::BodyPoints>(
        control::GetBodyPoints{session, list.version, points.count()});
    if (part.points.empty()) refuse_empty(dialogue, "the tool");
    require_near(dialogue, part.points);
    points.add(part.points, "the tool");
  }
  body.points = points.take();
  return body;
}

}  // namespace feltwire
