#include "client/transport/scene_fetch.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "client/transport/control_dialogue.hpp"
#include "client/transport/fetch_room.hpp"
#include "client/transport/fetched_parts.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"

namespace feltwire {
namespace {

constexpr int kLeastPriority = 19;
constexpr std::chrono::milliseconds kFirstWait{1000}, kLongestWait{30'000};

using Fetched = std::shared_ptr<const FetchedScene>;

/// Fetched scene for the servo, or the reason for its refusal.
struct Judged {
  Fetched scene;
  std::string refusal;
};

/// Lists of geometry that the server offers. Version 0 means no geometry.
struct Offer {
  std::uint32_t version = 0;
  control::SurfaceList surfaces;  // for a tool that is a point or a ball
  control::SolidList solids;      // for a tool with a body
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

std::string refusal_of(const std::string& why) { return "nothing of the scene is fetched: " + why; }

/// Fetches the offered geometry. Returns null if there is none.
std::shared_ptr<FetchedScene> fetch(ControlDialogue& dialogue, std::uint64_t session,
                                    const Offer& offer) {
  auto all = std::make_shared<FetchedScene>();
  if (offer.solids.body) {
    const std::vector<SolidData> solids = fetched_solids(dialogue, session, offer.solids);
    all->body = make_prefetched_tool(offer.version, fetched_body(dialogue, session, offer.solids),
                                     solids, FetchRoom::kMostGridBytes);
    all->objects = all->body->objects;
    return all;
  }
  const std::vector<SurfaceData> surfaces = fetched_surfaces(dialogue, session, offer.surfaces);
  if (surfaces.empty()) return nullptr;
  for (const SurfaceData& surface : surfaces) all->objects.push_back(surface.object);
  all->surfaces = mesh_surfaces(offer.version, surfaces);
  return all;
}

/// Measures the time per unit of contact work on this machine, and sets the scene's work limit per
/// tick. Refuses a scene that is too costly.
Judged judged(std::shared_ptr<FetchedScene> scene, const SceneFetchOptions& options) {
  if (scene == nullptr) return {};
  const ContactCost cost = contact_cost(*scene, options.servo_period, options.clock);
  if (auto refusal = too_costly(cost, options.servo_period))
    return {.scene = nullptr, .refusal = *std::move(refusal)};
  scene->most_work = units_within(contact_budget(options.servo_period), cost.unit);
  return {.scene = std::move(scene), .refusal = {}};
}

}  // namespace

SceneFetch::SceneFetch(ServerAccess server, Ring<const FetchedScene*>& out,
                       SceneFetchOptions options)
    : server_(std::move(server)), out_(out), options_(std::move(options)), wait_(kFirstWait) {}

SceneFetch::Attempt SceneFetch::attempt(const Question& question) {
  // Sampling a mesh uses all processors for seconds, so the servo must have priority.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kLeastPriority);
  try {
    ControlDialogue dialogue(question.server, question.options.timeout);
    const std::uint64_t session = question.session;
    const Offer offer = offered(dialogue, session);
    if (offer.version == 0) return {};
    if (version_of(question.have) != offer.version) {
      if (question.full) return {.failed = true};
      Judged done = judged(fetch(dialogue, session, offer), question.options);
      return {.fetched = std::move(done.scene), .refusal = std::move(done.refusal)};
    }
    const control::TakeSurfaces take{session, offer.version, question.have->objects};
    dialogue.ask_for<control::SurfacesTaken>(take);
    return {.known = take.objects.size()};
  } catch (const FalseAnswer& error) {
    return {.failed = true, .refusal = refusal_of(error.what())};
  } catch (const LastingError&) {  // server or scene does not support the fetch
    return {};
  } catch (const std::invalid_argument& error) {
    return {.failed = true,
            .refusal = refusal_of(to_string(question.server.endpoint) +
                                  " sent a scene that cannot be: " + error.what())};
  } catch (const std::exception&) {  // the next attempt may have enough memory
    return {.failed = true};
  }
}

SceneFetch::Attempt SceneFetch::outcome() noexcept {
  try {
    return attempt_.get();
  } catch (const std::exception&) {
    return {.failed = true};
  } catch (const Cancelled&) {  // the process ends
    return {.failed = true};
  }
}

void SceneFetch::look(const ScenePlace& place, Clock::time_point now) noexcept {
  if (attempt_.valid()) {
    if (!attempt_.is_ready()) return;
    Attempt done = outcome();
    if (done.failed) {
      put_off(now);
      if (!done.refusal.empty()) {
        settled_ = asked_for_;  // another attempt would give the same refusal
        refusal_ = std::move(done.refusal);
      }
    } else if (done.fetched == nullptr) {
      known_ = done.known;
      refusal_ = std::move(done.refusal);
      settled_ = asked_for_;
      unsettled_ = false;
      wait_ = kFirstWait;
    } else {
      // Pause, because the scene may change at every fetch.
      if (std::exchange(unsettled_, true)) put_off(now);
      hand_over(std::move(done.fetched));
    }
    return;
  }
  if (place.session == 0 || place == settled_ || now < next_) return;
  try {
    begin(place);
  } catch (const std::exception&) {  // missing memory or thread
    attempt_ = {};
    next_ = now + wait_;
  }
}

void SceneFetch::put_off(Clock::time_point now) noexcept {
  next_ = now + wait_;
  wait_ = std::min(2 * wait_, kLongestWait);
}

void SceneFetch::hand_over(Fetched fetched) noexcept {
  try {
    kept_.push_back(std::move(fetched));
  } catch (const std::bad_alloc&) {
    return;
  }
  if (!out_.push(kept_.back().get())) return kept_.pop_back();
  refusal_.clear();
  of_session_ = asked_for_.session;
}

void SceneFetch::in_use(const FetchedScene* fetched) noexcept {
  if (!kept_.empty() && kept_.back().get() == fetched) kept_.erase(kept_.begin(), kept_.end() - 1);
}

void SceneFetch::begin(const ScenePlace& place) {
  // Another session may use another server. Equal version numbers may then mean different scenes.
  const auto have = of_session_ == place.session ? kept_.back() : nullptr;
  attempt_ = BackgroundWork<Attempt>(
      [question = Question{server_, place.session, have, kept_.size() >= kMostKept, options_}] {
        return attempt(question);
      });
  asked_for_ = place;
}

}  // namespace feltwire
