#include "client/transport/scene_fetch.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/transport/control_dialogue.hpp"
#include "client/transport/detached.hpp"
#include "core/whole_surfaces/mesh_surfaces.hpp"
#include "core/whole_surfaces/whole_body.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {
namespace {

constexpr int kLeastPriority = 19;
constexpr std::chrono::milliseconds kFirstWait{1000}, kLongestWait{30'000};

bool near(const Vec3& v) { return v.cwiseAbs().maxCoeff() <= kMaxPosition && v.allFinite(); }

bool plausible(const Pose& pose) {
  return near(pose.position) && std::abs(pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
}

/// Numbers that a surface can have. NaN fails.
bool plausible(const SurfaceData& s) {
  return plausible(s.pose) && near(s.origin) && s.radius >= 0.0 && s.radius <= kMaxPosition &&
         s.grain >= 0.0 && s.grain <= kMaxPosition && s.grain_wavelength > 0.0 &&
         std::isfinite(s.grain_wavelength);
}

/// Fetches the vertices and triangles of a surface, part by part.
TriangleSoup fetched(ControlDialogue& dialogue, std::uint64_t session, std::uint32_t version,
                     std::uint16_t object, std::uint32_t vertices, std::uint32_t triangles) {
  TriangleSoup mesh;
  while (mesh.vertices.size() < vertices || mesh.triangles.size() < triangles) {
    const auto part = dialogue.ask_for<control::SurfacePart>(control::GetSurface{
        session, version, object, static_cast<std::uint32_t>(mesh.vertices.size()),
        static_cast<std::uint32_t>(mesh.triangles.size())});
    if (part.vertices.empty() && part.triangles.empty()) dialogue.bad_answer();
    if (!std::ranges::all_of(part.vertices, near)) dialogue.bad_answer();
    mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
    mesh.triangles.insert(mesh.triangles.end(), part.triangles.begin(), part.triangles.end());
  }
  return mesh;
}

/// How many triangles may still be fetched.
class Room {
 public:
  /// Whether a mesh of so many fits; then it takes its place.
  bool take(std::uint32_t vertices, std::uint32_t triangles) {
    // No more corners than triangles have: a server cannot make this grow.
    if (triangles > left_ || vertices > 3 * std::uint64_t{triangles}) return false;
    left_ -= triangles;
    return true;
  }

 private:
  std::uint32_t left_ = SceneFetch::kMostTriangles;
};

std::vector<SurfaceData> fetch(ControlDialogue& dialogue, std::uint64_t session,
                               const control::SurfaceList& list) {
  std::vector<SurfaceData> surfaces;
  Room room;
  for (const control::SurfaceEntry& entry : list.surfaces) {
    if (!room.take(entry.vertices, entry.triangles)) continue;
    if (!plausible(entry.surface)) dialogue.bad_answer();
    SurfaceData& surface = surfaces.emplace_back(entry.surface);
    TriangleSoup mesh =
        fetched(dialogue, session, list.version, surface.object, entry.vertices, entry.triangles);
    surface.vertices = std::move(mesh.vertices);
    surface.triangles = std::move(mesh.triangles);
  }
  return surfaces;
}

std::vector<SolidData> fetch(ControlDialogue& dialogue, std::uint64_t session,
                             const control::SolidList& list) {
  std::vector<SolidData> solids;
  Room room;
  for (const control::SolidEntry& entry : list.solids) {
    if (!plausible(entry.solid.pose)) dialogue.bad_answer();
    if (!room.take(entry.vertices, entry.triangles)) continue;
    SolidData& solid = solids.emplace_back(entry.solid);
    solid.mesh =
        fetched(dialogue, session, list.version, solid.object, entry.vertices, entry.triangles);
  }
  return solids;
}

/// Fetches the points of a body, part by part.
BodyData fetched(ControlDialogue& dialogue, std::uint64_t session, const control::SolidList& list) {
  BodyData body = *list.body;
  while (body.points.size() < list.points) {
    const auto part = dialogue.ask_for<control::BodyPoints>(control::GetBodyPoints{
        session, list.version, static_cast<std::uint32_t>(body.points.size())});
    if (part.points.empty() || !std::ranges::all_of(part.points, near)) dialogue.bad_answer();
    body.points.insert(body.points.end(), part.points.begin(), part.points.end());
  }
  return body;
}

using Fetched = std::shared_ptr<const FetchedScene>;

/// The server's lists of what a client may fetch. Version 0: there is nothing to fetch.
struct Offer {
  std::uint32_t version = 0;
  control::SurfaceList surfaces;  // for a point or a ball
  control::SolidList solids;      // for a body
};

Offer offered(ControlDialogue& dialogue, std::uint64_t session) {
  Offer offer;
  offer.surfaces = dialogue.ask_for<control::SurfaceList>(control::ListSurfaces{session});
  if (!offer.surfaces.surfaces.empty()) {
    offer.version = offer.surfaces.version;
    return offer;
  }
  offer.solids = dialogue.ask_for<control::SolidList>(control::ListSolids{session});
  if (offer.solids.body && offer.solids.points <= kMostBodyPoints)
    offer.version = offer.solids.version;
  return offer;
}

std::uint32_t version_of(const Fetched& have) {
  if (have == nullptr) return 0;
  return have->body != nullptr ? have->body->version : have->surfaces->version();
}

/// Null: nothing of it is of use.
Fetched fetch(ControlDialogue& dialogue, std::uint64_t session, const Offer& offer) {
  auto all = std::make_shared<FetchedScene>();
  if (offer.solids.body) {
    const std::vector<SolidData> solids = fetch(dialogue, session, offer.solids);
    for (const SolidData& solid : solids) all->objects.push_back(solid.object);
    all->body = whole_body(offer.version, fetched(dialogue, session, offer.solids), solids);
    return all;
  }
  const std::vector<SurfaceData> surfaces = fetch(dialogue, session, offer.surfaces);
  if (surfaces.empty()) return nullptr;
  for (const SurfaceData& surface : surfaces) all->objects.push_back(surface.object);
  all->surfaces = mesh_surfaces(offer.version, surfaces);
  return all;
}

}  // namespace

SceneFetch::SceneFetch(ServerAccess server, Ring<const FetchedScene*>& out,
                       std::chrono::milliseconds timeout)
    : server_(std::move(server)), out_(out), timeout_(timeout), wait_(kFirstWait) {}

SceneFetch::Attempt SceneFetch::attempt(const Question& question) {
  // To sample a mesh takes all processors for seconds. The servo needs them more.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kLeastPriority);
  try {
    ControlDialogue dialogue(question.server, question.timeout);
    const std::uint64_t session = question.session;
    const Offer offer = offered(dialogue, session);
    if (offer.version == 0) return {};
    if (version_of(question.have) != offer.version)
      return {.fetched = fetch(dialogue, session, offer)};
    const control::TakeSurfaces take{session, offer.version, question.have->objects};
    dialogue.ask_for<control::SurfacesTaken>(take);
    return {.known = take.objects.size()};
  } catch (const LastingError&) {  // the server or the scene does not do it
    return {};
  } catch (const std::exception&) {  // also no memory: the next may have it
    return {.failed = true};
  }
}

SceneFetch::Attempt SceneFetch::outcome() noexcept {
  try {
    return attempt_.get();
  } catch (const std::exception&) {
    return {.failed = true};
  }
}

void SceneFetch::look(const ScenePlace& place, Clock::time_point now) noexcept {
  if (attempt_.valid()) {
    if (attempt_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    Attempt done = outcome();
    if (done.failed) {
      next_ = now + wait_;
      wait_ = std::min(2 * wait_, kLongestWait);
    } else if (done.fetched == nullptr) {
      known_ = done.known;
      settled_ = asked_for_;
      wait_ = kFirstWait;
    } else {
      hand_over(std::move(done.fetched));
    }
    return;
  }
  if (place.session == 0 || place == settled_ || now < next_) return;
  try {
    begin(place);
  } catch (const std::exception&) {  // no memory or no thread
    attempt_ = {};
    next_ = now + wait_;
  }
}

void SceneFetch::hand_over(Fetched fetched) noexcept {
  try {
    kept_.push_back(std::move(fetched));
  } catch (const std::bad_alloc&) {
    return;
  }
  if (!out_.push(kept_.back().get())) return kept_.pop_back();
  of_session_ = asked_for_.session;
}

void SceneFetch::in_use(const FetchedScene* fetched) noexcept {
  if (!kept_.empty() && kept_.back().get() == fetched) kept_.erase(kept_.begin(), kept_.end() - 1);
}

void SceneFetch::begin(const ScenePlace& place) {
  // Another session may be another server's: it may count other scenes by the same numbers.
  const auto have = of_session_ == place.session ? kept_.back() : nullptr;
  attempt_ = run_detached(
      [question = Question{server_, place.session, have, timeout_}] { return attempt(question); });
  asked_for_ = place;
}

}  // namespace feltwire
