#include "client/transport/scene_fetch.hpp"

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
SurfaceData fetched(ControlDialogue& dialogue, std::uint64_t session, std::uint32_t version,
                    const control::SurfaceEntry& entry) {
  SurfaceData surface = entry.surface;
  while (surface.vertices.size() < entry.vertices || surface.triangles.size() < entry.triangles) {
    const auto part = dialogue.ask_for<control::SurfacePart>(control::GetSurface{
        session, version, surface.object, static_cast<std::uint32_t>(surface.vertices.size()),
        static_cast<std::uint32_t>(surface.triangles.size())});
    if (part.vertices.empty() && part.triangles.empty()) dialogue.bad_answer();
    if (!std::ranges::all_of(part.vertices, near)) dialogue.bad_answer();
    surface.vertices.insert(surface.vertices.end(), part.vertices.begin(), part.vertices.end());
    surface.triangles.insert(surface.triangles.end(), part.triangles.begin(), part.triangles.end());
  }
  return surface;
}

std::vector<SurfaceData> fetch(ControlDialogue& dialogue, std::uint64_t session,
                               const control::SurfaceList& list) {
  std::vector<SurfaceData> surfaces;
  std::uint32_t left = SceneFetch::kMostTriangles;
  for (const control::SurfaceEntry& entry : list.surfaces) {
    // No more corners than triangles have: a server cannot make this grow.
    if (entry.triangles > left || entry.vertices > 3 * std::uint64_t{entry.triangles}) continue;
    if (!plausible(entry.surface)) dialogue.bad_answer();
    left -= entry.triangles;
    surfaces.push_back(fetched(dialogue, session, list.version, entry));
  }
  return surfaces;
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

/// What the server has for a client. The version is 0 where that is nothing.
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
  if (offer.solids.body && offer.solids.points <= SceneFetch::kMostPoints)
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
    for (const SolidData& solid : offer.solids.solids) {
      if (!plausible(solid.pose)) dialogue.bad_answer();
      all->objects.push_back(solid.object);
    }
    all->body =
        whole_body(offer.version, fetched(dialogue, session, offer.solids), offer.solids.solids);
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
