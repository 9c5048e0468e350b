#include "client/transport/surface_fetch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/transport/control_dialogue.hpp"
#include "client/transport/detached.hpp"
#include "core/whole_surfaces/mesh_surfaces.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kFirstWait{1000}, kLongestWait{30'000};

bool near(const Vec3& v) { return v.cwiseAbs().maxCoeff() <= kMaxPosition && v.allFinite(); }

/// Numbers that a surface can have. NaN fails.
bool plausible(const SurfaceData& s) {
  return near(s.pose.position) && near(s.origin) &&
         std::abs(s.pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance && s.radius >= 0.0 &&
         s.radius <= kMaxPosition && s.grain >= 0.0 && s.grain <= kMaxPosition &&
         s.grain_wavelength > 0.0 && std::isfinite(s.grain_wavelength);
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
  std::uint32_t left = SurfaceFetch::kMostTriangles;
  for (const control::SurfaceEntry& entry : list.surfaces) {
    // No more corners than triangles have: a server cannot make this grow.
    if (entry.triangles > left || entry.vertices > 3 * std::uint64_t{entry.triangles}) continue;
    if (!plausible(entry.surface)) dialogue.bad_answer();
    left -= entry.triangles;
    surfaces.push_back(fetched(dialogue, session, list.version, entry));
  }
  return surfaces;
}

}  // namespace

SurfaceFetch::SurfaceFetch(ServerAccess server, Ring<const WholeSurfaces*>& out,
                           std::chrono::milliseconds timeout)
    : server_(std::move(server)), out_(out), timeout_(timeout), wait_(kFirstWait) {}

SurfaceFetch::Attempt SurfaceFetch::attempt(const Question& question) {
  try {
    ControlDialogue dialogue(question.server, question.timeout);
    const std::uint64_t session = question.session;
    const auto list = dialogue.ask_for<control::SurfaceList>(control::ListSurfaces{session});
    if (question.have == nullptr || question.have->version() != list.version) {
      std::vector<SurfaceData> surfaces = fetch(dialogue, session, list);
      if (surfaces.empty() || list.version == 0) return {};
      return {.surfaces = mesh_surfaces(list.version, surfaces)};
    }
    control::TakeSurfaces take{session, list.version, {}};
    for (const control::SurfaceEntry& entry : list.surfaces)
      if (question.have->has(entry.surface.object)) take.objects.push_back(entry.surface.object);
    dialogue.ask_for<control::SurfacesTaken>(take);
    return {.known = take.objects.size()};
  } catch (const LastingError&) {  // the server or the scene does not do it
    return {};
  } catch (const std::exception&) {  // also no memory: the next may have it
    return {.failed = true};
  }
}

SurfaceFetch::Attempt SurfaceFetch::outcome() noexcept {
  try {
    return attempt_.get();
  } catch (const std::exception&) {
    return {.failed = true};
  }
}

void SurfaceFetch::look(const ScenePlace& place, Clock::time_point now) noexcept {
  if (attempt_.valid()) {
    if (attempt_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    Attempt done = outcome();
    if (done.failed) {
      next_ = now + wait_;
      wait_ = std::min(2 * wait_, kLongestWait);
    } else if (done.surfaces == nullptr) {
      known_ = done.known;
      settled_ = asked_for_;
      wait_ = kFirstWait;
    } else {
      hand_over(std::move(done.surfaces));
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

void SurfaceFetch::hand_over(std::shared_ptr<const WholeSurfaces> surfaces) noexcept {
  try {
    kept_.push_back(std::move(surfaces));
  } catch (const std::bad_alloc&) {
    return;
  }
  if (!out_.push(kept_.back().get())) return kept_.pop_back();
  of_session_ = asked_for_.session;
}

void SurfaceFetch::in_use(const WholeSurfaces* surfaces) noexcept {
  if (!kept_.empty() && kept_.back().get() == surfaces) kept_.erase(kept_.begin(), kept_.end() - 1);
}

void SurfaceFetch::begin(const ScenePlace& place) {
  // Another session may be another server's: it may count other scenes by the same numbers.
  const auto have = of_session_ == place.session ? kept_.back() : nullptr;
  attempt_ = run_detached(
      [question = Question{server_, place.session, have, timeout_}] { return attempt(question); });
  asked_for_ = place;
}

}  // namespace feltwire
