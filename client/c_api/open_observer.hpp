#pragma once
// An observer of a program that uses the library.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/c_api/feltwire.h"
#include "client/c_api/message_queue.hpp"
#include "client/observer/observer_session.hpp"
#include "client/run/observed_scene.hpp"
#include "client/servo/event.hpp"
#include "client/transport/backoff.hpp"
#include "client/transport/fleet_route.hpp"
#include "core/base/latest_list.hpp"
#include "core/base/latest_value.hpp"

namespace feltwire {

/// A session that observes, and a thread that looks after it. Any thread may use it.
class OpenObserver {
 public:
  /// Joins the scene. `patience` [s]: for which a lost session is looked for. Throws as join()
  /// does.
  OpenObserver(ServerAccess server, ObserverRequest request, double patience);
  ~OpenObserver();
  OpenObserver(const OpenObserver&) = delete;
  OpenObserver& operator=(const OpenObserver&) = delete;

  /// Returns the newest state in `state`; false: no view has come yet. It never waits.
  bool latest(fw_scene_state& state) const noexcept;
  /// The hands and bodies of the newest state. They never wait.
  const LatestList<fw_seen_hand>& hands() const noexcept { return hands_; }
  const LatestList<fw_seen_body>& bodies() const noexcept { return bodies_; }
  /// The name that the client of a hand gives itself; empty: it is not known.
  std::optional<std::string> name_of(std::uint32_t hand) const;
  MessageQueue& messages() noexcept { return messages_; }

  enum class News { newer, none, ended };
  /// Waits for a state with a number greater than `number`, at most `timeout` [s].
  News wait(std::uint64_t number, double timeout) const;
  /// Leaves the scene, and waits for it. Returns the error that had ended the observer; empty: none
  /// had.
  std::string end() noexcept;
  /// The error that has ended it; empty: none has.
  std::string error() const;

 private:
  /// A state, and when its newest view came.
  struct State {
    fw_scene_state state;
    std::int64_t clock;  // [ns] monotonic
  };

  /// [s] of the view that told of a hand or body.
  struct ViewTimes {
    std::map<std::uint32_t, double> hands;
    std::map<std::uint16_t, double> bodies;
  };
  /// The mutex guards the members after it.
  struct Shared {
    mutable std::mutex mutex;
    mutable std::condition_variable changed;
    std::uint64_t number = 0;  // of the newest state
    bool ended = false;
    std::string error;
    std::map<std::uint32_t, std::string> names;  // of hands
  };

  void run();
  std::string observe(ObserverSession& session);
  std::unique_ptr<ObserverSession> find_again(std::string& why);
  void take(const TimedView& shown, double began);
  void publish(bool connected);
  void ask_names(const Event& over);
  bool ask_once();

  FleetRoute route_;  // of the thread; another thread asks the host only while a session lasts
  const ObserverRequest request_;
  const double patience_;  // [s]
  std::int64_t opened_;    // [ns] monotonic
  std::unique_ptr<ObserverSession> session_;
  // Members of the thread.
  ObservedScene seen_;
  ViewTimes times_;
  std::vector<fw_seen_hand> told_hands_;
  std::vector<fw_seen_body> told_bodies_;
  State newest_{};
  // Members that all threads read.
  LatestValue<State> latest_;
  LatestList<fw_seen_hand> hands_{ObservedScene::kMostHands};
  LatestList<fw_seen_body> bodies_{ObservedScene::kMostBodies};
  MessageQueue messages_;
  Shared shared_;
  std::atomic<bool> has_newcomers_{false};  // hands whose names are not known
  Event stop_;
  std::thread thread_;
};

}  // namespace feltwire
