#include "tests/soak/soak.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>

#include "core/scene_file/load_scene.hpp"
#include "protocol/net/clock.hpp"
#include "server/app/server.hpp"
#include "tests/soak/resources.hpp"
#include "tests/support/security.hpp"

namespace feltwire::soak {
namespace {

constexpr double kSilenceTimeout = 1.0;  // [s]
constexpr int kSeatsPerClient =
    4;  // A dead client's session stays until the server's silence timeout.
constexpr double kWarmUp = 0.25;    // share of the time
constexpr double kPatience = 10.0;  // [s] longest wait for an expected end
constexpr auto kLook = std::chrono::milliseconds(5);
constexpr Nanoseconds kBetweenLooks = std::chrono::milliseconds(250);
#ifdef FELTWIRE_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr double kMebibyte = 1048576.0;
// The allowed growth. Allocators and kernels keep some freed memory.
constexpr double kResidentGrowth = 4.0 * kMebibyte, kHeapGrowth = 0.25 * kMebibyte;

/// Polls the condition. Returns false if the condition stays false for kPatience.
template <class Condition>
bool becomes(Condition condition) {
  const Nanoseconds end = monotonic_now() + from_seconds(kPatience);
  while (!condition()) {
    if (monotonic_now() >= end) return false;
    std::this_thread::sleep_for(kLook);
  }
  return true;
}

std::string mebibytes(double bytes) {
  return std::to_string(bytes / kMebibyte).substr(0, 6) + " MiB";
}

/// Only this function makes a server.
Server make_server(const Options& options) {
  spdlog::set_level(spdlog::level::off);  // Log lines for every join are not necessary here.
  ServerConfig config;
  config.port = 0;
  config.silence_timeout = kSilenceTimeout;
  config.max_sessions_per_scene = kSeatsPerClient * options.clients;
  // All sessions belong to one client at one address.
  config.max_sessions_per_client = config.max_sessions_per_scene;
  config.join_rate = config.join_burst = 1e3;
  config.connections.handshake_rate = config.connections.handshake_burst = 1e4;
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(options.scene_file));
  return {config, std::move(scenes), test::security()};
}

class Soak {
 public:
  explicit Soak(const Options& options)
      : options_(options),
        descriptors_before_(descriptors()),
        server_(std::make_unique<Server>(make_server(options))),
        access_(test::access(server_->control_port())) {
    for (int i = 0; i < options.clients; ++i) {
      const auto seed = splitmix::draw(options.seed, static_cast<std::uint64_t>(i));
      clients_.emplace_back(
          ClientOptions{access_, server_->scenes().front().scene, from_seconds(1.0 / options.rate),
                        from_seconds(kSilenceTimeout), seed},
          outcome_.clients);
    }
  }

  Outcome run() {
    const std::size_t descriptors_at_rest = descriptors();
    const auto at_rest = [&] { return descriptors() == descriptors_at_rest; };
    sessions();  // The first answer allocates memory that the server keeps.
    becomes(at_rest);
    const std::size_t heap_at_rest = heap_in_use();
    play();
    const auto sessions_left = end_sessions();
    check("sessions after all were gone for the silence timeout", std::to_string(sessions_left),
          sessions_left == 0);
    for (Client& client : clients_) client.forget();
    const bool closed = becomes(at_rest);
    check("descriptors as before the first client",
          std::to_string(descriptors()) + " of " + std::to_string(descriptors_at_rest), closed);
    judge_memory(heap_at_rest);
    server_->stop();
    outcome_.server = server_->summary().front();
    server_.reset();
    check("descriptors as before the server",
          std::to_string(descriptors()) + " of " + std::to_string(descriptors_before_),
          descriptors() == descriptors_before_);
    judge_clients();
    judge_server();
    return outcome_;
  }

 private:
  std::uint32_t sessions() const {
    return list_scenes(access_, std::chrono::seconds(5)).front().sessions;
  }

  void play() {
    const Nanoseconds start = monotonic_now(), period = from_seconds(1.0 / options_.rate);
    const Nanoseconds end = start + from_seconds(options_.seconds);
    const Nanoseconds warm = start + from_seconds(kWarmUp * options_.seconds);
    Nanoseconds next_look = warm;
    std::uint64_t rounds = 0;
    for (Nanoseconds now = start; now < end; now = monotonic_now(), ++rounds) {
      for (Client& client : clients_) client.tick(monotonic_now());
      if (now >= next_look) {
        resident_.push_back(resident_memory());
        for (Client& client : clients_) client.watch_old_ports(now);
        next_look = now + kBetweenLooks;
      }
      // The loop skips missed ticks.
      const Nanoseconds spare = now + period - monotonic_now();
      if (spare.count() > 0) std::this_thread::sleep_for(spare);
    }
    outcome_.rate = static_cast<double>(rounds) / seconds(monotonic_now() - start);
  }

  std::uint32_t end_sessions() {
    const Nanoseconds now = monotonic_now();
    for (Client& client : clients_) client.end(now);
    std::uint32_t left = 0;
    becomes([&] {
      for (Client& client : clients_) client.watch_old_ports(now);
      left = sessions();
      return left == 0;
    });
    return left;
  }

  void judge_memory(std::size_t heap_at_rest) {
    if (kSanitized) return;  // The sanitizer has its own allocator and finds leaks itself.
    // Clients join and leave, so the check compares the maximum of the later half with that of the
    // earlier half.
    const auto middle = resident_.begin() + static_cast<std::ptrdiff_t>(resident_.size() / 2);
    const auto earlier = static_cast<double>(*std::max_element(resident_.begin(), middle));
    const auto later = static_cast<double>(*std::max_element(middle, resident_.end()));
    check("resident memory after the warm-up grows by at most " + mebibytes(kResidentGrowth),
          mebibytes(earlier) + ", then " + mebibytes(later), later - earlier <= kResidentGrowth);
    const double kept = static_cast<double>(heap_in_use()) - static_cast<double>(heap_at_rest);
    check("heap that nobody gave back: at most " + mebibytes(kHeapGrowth), mebibytes(kept),
          kept <= kHeapGrowth);
  }

  void judge_clients() {
    const Account& c = outcome_.clients;
    const auto none = [&](const char* what, std::uint64_t count) {
      check(what, std::to_string(count), count == 0);
    };
    none("violations of passivity at any port", c.violations);
    none("forces that are not finite or beyond the device", c.faulty_forces);
    none("datagrams at a port of another session", c.misaddressed);
    none("datagrams that were dropped", c.dropped);
    none("living clients that were sent away", c.sent_away);
    none("joins that were refused", c.refused);
    check("each thing happened: lives, leaving, dying, roaming, forces",
          std::to_string(c.lives) + ", " + std::to_string(c.left) + ", " + std::to_string(c.died) +
              ", " + std::to_string(c.roamed) + ", " + std::to_string(c.with_force),
          c.lives > 0 && c.left > 0 && c.died > 0 && c.roamed > 0 && c.with_force > 0);
  }

  void judge_server() {
    const SceneCounters& s = outcome_.server.counters;
    check("sessions served, by the server and by the clients",
          std::to_string(s.sessions_served) + ", " + std::to_string(outcome_.clients.lives),
          s.sessions_served == outcome_.clients.lives);
    check("of these left and silent, by the server and by the clients",
          std::to_string(s.left) + "+" + std::to_string(s.silent) + ", " +
              std::to_string(outcome_.clients.left) + "+" + std::to_string(outcome_.clients.died),
          s.left == outcome_.clients.left && s.silent == outcome_.clients.died);
    // The second and third goodbye of a leaving client find no session.
    std::uint64_t dropped = 0;
    for (std::size_t i = 0; i < s.drops.size(); ++i)
      if (i != static_cast<std::size_t>(DropReason::session)) dropped += s.drops[i];
    check("datagrams that the server dropped, late goodbyes apart", std::to_string(dropped),
          dropped == 0);
  }

  void check(std::string what, std::string measured, bool holds) {
    outcome_.checks.push_back({std::move(what), std::move(measured), holds});
  }

  Options options_;
  std::size_t descriptors_before_;
  std::unique_ptr<Server> server_;
  ServerAccess access_;
  Outcome outcome_;
  std::vector<Client> clients_;
  std::vector<std::size_t> resident_;  // [bytes] one value per check after the warm-up
};

}  // namespace

Outcome run(const Options& options) { return Soak(options).run(); }

}  // namespace feltwire::soak
