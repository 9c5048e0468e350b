#pragma once
// A scene host has one scene, one thread and one UDP socket. It shares nothing, so it locks
// nothing.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "protocol/net/busy_poll.hpp"
#include "protocol/net/clock.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/scene/datagram_exchange.hpp"
#include "server/scene/host_log.hpp"
#include "server/scene/operation_memory.hpp"
#include "server/scene/published_scene.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

struct SceneHostOptions {
  asio::ip::address address;  // to listen on
  std::uint16_t port = 0;     // 0: the operating system chooses
  int socket = -1;            // already bound, and owned by the host from now on; -1: none
  /// Called in the scene's thread with the ended sessions and their ends. May be empty.
  std::function<void(std::vector<EndedSession>)> ended = {};
  Nanoseconds silence_timeout{};
  std::size_t max_sessions = 64;
  SessionLimits limits = {};
  const NetworkProfile* line = nullptr;  // shared by the sessions; null: no limit
  /// The time for which the thread polls for datagrams after the last one, before it sleeps until
  /// the next; 0: not at all, kForever: it never sleeps, and its core does nothing else.
  Nanoseconds busy_poll{0};
  /// Asks for SCHED_FIFO, unless the thread never sleeps, and for memory to be locked.
  bool real_time = false;
  int dscp = 0;  // of the replies (protocol/net/udp_socket.hpp)
  /// Receives the inputs that decide the scene's replies; it outlives the host. Null: nothing is
  /// recorded.
  EventLog* events = nullptr;
  /// The monotonic clock of the scene. Only the scene's thread reads it. Tests give their own.
  std::function<Nanoseconds()> clock = monotonic_now;
};

/// The totals of a scene's host, for the summary.
struct SceneSummary {
  std::string scene;
  SceneCounters counters;
  std::uint64_t unsent = 0;    // replies that the operating system did not accept
  std::uint32_t sessions = 0;  // present sessions
  TimeCounts answers;          // of each datagram: from its processing to its answer
};

/// Owns the thread, its timers and the requests of other threads that it handles. The thread
/// answers datagrams (DatagramExchange), and publishes the state of the scene (PublishedScene).
class SceneHost final : public SceneInView, public SceneControls {
 public:
  /// Binds the port. Throws std::runtime_error in one line when it cannot.
  SceneHost(Scene scene, const SceneHostOptions& options);
  ~SceneHost() override;
  SceneHost(const SceneHost&) = delete;
  SceneHost& operator=(const SceneHost&) = delete;

  /// Starts the thread. Call once.
  void start();
  /// Says goodbye to every client and joins the thread. May be called again.
  void stop();

  const std::string& name() const override { return name_; }
  std::uint16_t port() const { return datagrams_.port(); }
  /// Sessions at this moment, from any thread.
  std::uint32_t sessions() const { return published_.sessions(); }
  /// The scene's objects at this moment, from any thread.
  std::uint32_t objects() const { return published_.objects(); }

  using Completion = std::function<void(control::Message)>;
  /// Lets the scene's thread answer (see SceneSessions::answer) and posts the answer to `back`,
  /// which must outlive this host's thread. From any thread.
  void ask(control::Message request, std::uint64_t id, const SessionKeys& keys,
           asio::io_context& back, Completion completion);
  /// Moves all sessions to another scene, which keeps this one's name; sessions whose tool it does
  /// not have end. Their bounds continue, so the change gives no hand energy. If that fails (no
  /// memory) the scene stays, and the log says so. From any thread.
  void reload(Scene scene);
  /// Changes the scene in the scene's thread, between two datagrams (SceneSessions::change).
  void change(LiveChange change, PostBack back,
              std::function<void(std::variant<std::string, control::Refused>)> done) override;
  void evict(std::uint64_t session) override;

  CurrentScene current_scene() const override { return published_.current(); }
  /// Takes the newest picture for viewers. While pictures are wanted, the scene makes one with the
  /// next datagrams, or within 0.1 s if none come.
  bool take_picture(Picture& picture) override { return published_.pictures().take(picture); }
  /// Pictures for a recorder's thread.
  PictureExchange& recorded_pictures() { return published_.recorded_pictures(); }
  /// Describes the hands in the scene's thread, and posts the answer back.
  void describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) override;
  SceneControls* controls() override { return this; }

  /// The totals up to now, from a running thread. Do not call it in that thread, or while another
  /// thread stops it.
  SceneSummary summary();

 private:
  /// An operation that is started again and again.
  struct Wait {
    OperationMemory memory;
    bool pending = false;
  };

  void ask_for_real_time();
  void run();
  void turn();
  void recover(const std::exception& failure) noexcept;
  void spin();
  void await_datagrams();
  void serve();
  std::size_t exchange(std::optional<Nanoseconds>& until);
  bool posts_wait() const noexcept { return posts_.load(std::memory_order_relaxed) > 0; }
  template <class Handler>
  void post(Handler handler);
  void await_silence();
  void await_tick();
  void enter(std::shared_ptr<const Scene> next);
  std::variant<std::string, control::Refused> make(const LiveChange& change);
  void publish();
  void check(Nanoseconds now) noexcept;
  SceneSummary count() const;

  std::string name_;
  std::shared_ptr<const Scene> scene_;
  PublishedScene published_;
  const SceneHostOptions options_;
  Nanoseconds checked_at_{0};
  SceneSessions sessions_;
  std::atomic<int> posts_{0};                      // posted requests that are not yet handled
  Wait datagram_wait_, silence_wait_, tick_wait_;  // they outlive Asio's references
  asio::io_context io_{1};
  DatagramExchange datagrams_;
  asio::steady_timer silence_timer_{io_};
  asio::steady_timer tick_timer_{io_};
  HostLog log_;
  // Only for the scene's thread:
  bool closing_ = false;
  std::thread thread_;
};

}  // namespace feltwire
