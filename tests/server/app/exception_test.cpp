// An exception in a server handler must end at most its connection or its scene.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <asio/executor_work_guard.hpp>
#include <fstream>
#include <future>
#include <thread>

#include "core/scene_file/load_scene.hpp"
#include "server/app/server.hpp"
#include "server/app/signals.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/failing_allocation.hpp"

namespace feltwire::exception_test {
namespace {

using namespace std::chrono_literals;
using control::RefusalCode;
using control::Refused;
using test::ControlClient;
using ::testing::EndsWith;
using ::testing::HasSubstr;

/// An endpoint with special answers. A list of sessions throws. A list of scenes, or a later leave
/// request, gets an answer that is too long for a frame. The endpoint stores the answer to a
/// reload, drops the answer to SetParameters, and answers other requests as evictions.
class Endpoint {
 public:
  Endpoint()
      : endpoint_(io_, {.address = asio::ip::make_address("127.0.0.1")}, test::identity(), {},
                  [this](ControlPeer& peer, const control::Message& request,
                         std::function<void(control::Message)> answer) {
                    handle(peer, request, std::move(answer));
                  }) {
    endpoint_.start();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Endpoint() {
    asio::post(io_, [this] {
      endpoint_.close();
      io_.stop();
    });
    thread_.join();
  }
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  std::uint16_t port() const { return endpoint_.port(); }
  void end_lost() {
    asio::post(io_, [this] { endpoint_.end_lost(); });
  }

 private:
  void handle(ControlPeer& peer, const control::Message& request,
              std::function<void(control::Message)> answer) {
    control::SceneList too_long;
    too_long.scenes.push_back({std::string(control::kMaxFrame, 'x'), 1, 1, 1});
    if (std::holds_alternative<control::Authenticate>(request)) {
      peer.token = "some";
      answer(control::Authenticated{});
    } else if (std::holds_alternative<control::ListSessions>(request)) {
      throw std::runtime_error("injected");
    } else if (std::holds_alternative<control::ListScenes>(request)) {
      answer(too_long);
    } else if (std::holds_alternative<control::LeaveRequest>(request)) {
      asio::post(io_, [answer, too_long] { answer(too_long); });
    } else if (std::holds_alternative<control::ReloadScene>(request)) {
      kept_ = std::move(answer);
    } else if (std::holds_alternative<control::SetParameters>(request)) {
      answer = nullptr;
    } else {
      answer(control::Evicted{7});
    }
  }

  asio::io_context io_{1};
  std::function<void(control::Message)> kept_;
  ControlEndpoint endpoint_;
  std::thread thread_;
};

TEST(Exceptions, OfAControlHandlerEndItsConnectionOnly) {
  Endpoint endpoint;
  ControlClient other(endpoint.port());
  for (const control::Message& request :
       {control::Message(control::ListSessions{}), control::Message(control::ListScenes{}),
        control::Message(control::LeaveRequest{})}) {
    ControlClient client(endpoint.port());
    client.send(request);
    EXPECT_TRUE(client.closed());
    EXPECT_EQ(other.ask<control::Evicted>(control::Evict{7}).session, 7u);
  }
  ControlClient later(endpoint.port());
  EXPECT_EQ(later.ask<control::Evicted>(control::Evict{7}).session, 7u);
}

/// The client of the lost answer must not wait forever.
TEST(Exceptions, AConnectionWhoseAnswerIsLostEndsAndNoOther) {
  Endpoint endpoint;
  ControlClient idle(endpoint.port()), waiting(endpoint.port()), lost(endpoint.port());
  waiting.send(control::ReloadScene{"room"});
  lost.send(control::SetParameters{1, test::server_bounds()});
  const auto has_ended = [&] {
    endpoint.end_lost();
    pollfd ended{lost.descriptor(), POLLIN, 0};
    return ::poll(&ended, 1, 1) == 1;
  };
  ASSERT_TRUE(test::becomes(has_ended));
  EXPECT_TRUE(lost.closed());
  EXPECT_EQ(idle.ask<control::Evicted>(control::Evict{7}).session, 7u);
  pollfd open{waiting.descriptor(), POLLIN, 0};
  EXPECT_EQ(::poll(&open, 1, 0), 0);
}

/// The refusal lists 700 names and is too long for a frame.
TEST(Exceptions, ARefusalLongerThanAFrameIsCutAndTheServerGoesOn) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  const auto write = [&](const std::string& used) {
    std::ofstream out(file);
    out << R"({"name": "room", "materials": [)";
    for (int i = 0; i < 700; ++i)
      out << (i > 0 ? "," : "") << R"({"name": "m)" << i << std::string(94, 'x')
          << R"(", "stiffness": 500})";
    out << R"(], "objects": [{"name": "floor", "plane": {}, "material": ")" << used << R"("}]})";
  };
  write("m0" + std::string(94, 'x'));
  ServerConfig config = test::any_port();
  config.scenes = {file};
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(file));
  Server server(config, std::move(scenes), test::security());
  ControlClient other(server.control_port());
  ControlClient admin(server.control_port());
  write("typo");
  const auto refused = admin.ask<Refused>(control::ReloadScene{"room"});
  EXPECT_EQ(refused.code, RefusalCode::bad_scene);
  EXPECT_LE(refused.reason.size(), control::kMaxReason);
  EXPECT_THAT(refused.reason, HasSubstr("there is no material 'typo'"));
  EXPECT_THAT(refused.reason, EndsWith(" [...]"));
  EXPECT_EQ(admin.ask<control::SceneList>(control::ListScenes{}).scenes.size(), 1u);
  EXPECT_EQ(other.join(test::join_request()).accepted.port_offset, 1u);
}

/// Sends requests to a host as the control thread does, and waits for the answer.
class Asker {
 public:
  ~Asker() {
    work_.reset();
    thread_.join();
  }
  control::Message ask(SceneHost& host, control::Message request, std::uint64_t id) {
    std::promise<control::Message> answered;
    host.ask(std::move(request), id, test::keys(id), io_,
             [&](control::Message answer) { answered.set_value(std::move(answer)); });
    auto answer = answered.get_future();
    if (answer.wait_for(std::chrono::milliseconds(test::kPatience)) != std::future_status::ready)
      throw std::runtime_error("no answer");
    return answer.get();
  }

 private:
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_ = asio::make_work_guard(io_);
  std::thread thread_{[this] { io_.run(); }};
};

SceneHostOptions host_options() {
  SceneHostOptions options;
  options.address = asio::ip::make_address("127.0.0.1");
  options.silence_timeout = 100s;
  return options;
}

TEST(Exceptions, OfASceneEndItsSessionsAndNothingElse) {
  constexpr std::uint64_t kFirst = 0x100, kSecond = 0x200, kThird = 0x300;
  std::atomic<int> throwing{1};
  SceneHostOptions options = host_options();
  options.ended = [&](const std::vector<EndedSession>&) {
    if (throwing-- > 0) throw std::runtime_error("injected");
  };
  Asker asker;  // The asker outlives the threads that answer through it.
  SceneHost failing(test::room(), options), other(test::room(), host_options());
  failing.start();
  other.start();
  const auto joins = [&](SceneHost& host, std::uint64_t id) {
    return std::holds_alternative<control::JoinAccepted>(asker.ask(host, test::join_request(), id));
  };
  EXPECT_TRUE(joins(failing, kFirst));
  EXPECT_TRUE(joins(failing, kSecond));
  EXPECT_TRUE(joins(other, kFirst));
  // The server needs an address for the goodbye of the second session.
  test::RawSocket socket(SOCK_DGRAM, failing.port());
  test::SealedEncoder encoder(test::Way::up);
  socket.send(encoder.samples(kSecond, 1, test::hand_batch(1)));
  EXPECT_FALSE(socket.receive().empty());
  failing.evict(kFirst);
  GoodbyeReason reason = GoodbyeReason::leaving;
  EXPECT_EQ(decode(test::opened(socket.receive(), test::Way::down), reason), DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::failed);
  EXPECT_TRUE(joins(failing, kThird));
  EXPECT_EQ(failing.summary().counters.failed, 1u);
  EXPECT_EQ(failing.summary().counters.evicted, 1u);
  EXPECT_EQ(failing.sessions(), 1u);
  EXPECT_EQ(other.sessions(), 1u);
}

TEST(Exceptions, OfASignalHandlerEndNothing) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGUSR1, SIGHUP}) sigaddset(&signals, signal);
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &signals, &before);
  std::promise<void> counted, reloaded;
  std::atomic<int> end{0};
  std::thread waiting([&] {
    end = wait_for_end(signals, {.count =
                                     [&] {
                                       counted.set_value();
                                       throw std::runtime_error("injected");
                                     },
                                 .reload =
                                     [&] {
                                       reloaded.set_value();
                                       throw std::bad_alloc();
                                     }});
  });
  pthread_kill(waiting.native_handle(), SIGUSR1);
  counted.get_future().wait();
  pthread_kill(waiting.native_handle(), SIGHUP);
  reloaded.get_future().wait();
  pthread_kill(waiting.native_handle(), SIGTERM);
  waiting.join();
  EXPECT_EQ(end, SIGTERM);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

#ifndef FELTWIRE_SANITIZED
/// Each allocation of the server's threads fails once, in turn. Meanwhile a client joins, sends a
/// sample, changes parameters, is listed and evicted, and the scene is reloaded. All connections
/// stay open, so each connection needs its own memory.
/// tests/core/scene_file/load_scene_fault_test.cpp covers scene files.
TEST(Exceptions, OfEveryAllocationEndAtMostOneScene) {
  ServerConfig config = test::any_port();
  config.scenes = {"room.json"};
  config.join_burst = config.join_rate = 1e9;
  // Lost sessions stay for some time.
  config.max_sessions_per_client = config.max_sessions_per_scene = 1000;
  config.connections.max = config.connections.max_per_network = 2000;
  config.connections.handshake_burst = config.connections.handshake_rate = 1e9;
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  Server server(config, std::move(scenes), test::security(),
                [](const std::filesystem::path&) { return test::room(); });
  // A session that ends before its first sample gets no datagram.
  const auto hears = [](test::RawSocket& socket) {
    pollfd waiting{socket.descriptor(), POLLIN, 0};
    return ::poll(&waiting, 1, test::kPatience / 10) == 1 && !socket.receive().empty();
  };
  std::vector<std::unique_ptr<ControlClient>> open;
  const auto all_of_it = [&] {
    ControlClient& client =
        *open.emplace_back(std::make_unique<ControlClient>(server.control_port()));
    const auto joined = client.join(test::join_request());
    const std::uint64_t session = joined.accepted.session;
    test::RawSocket socket(SOCK_DGRAM, joined.udp_port);
    test::SealedEncoder encoder(test::Way::up, joined.keys);
    socket.send(encoder.samples(session, 1, test::hand_batch(1)));
    if (!hears(socket)) throw std::runtime_error("no reply");
    client.ask<control::ParametersSet>(control::SetParameters{session, test::server_bounds()});
    client.ask<control::SessionList>(control::ListSessions{});
    client.ask<control::SceneReloaded>(control::ReloadScene{"room"});
    client.ask<control::Evicted>(control::Evict{session});
    if (!hears(socket)) throw std::runtime_error("no goodbye");
  };
  all_of_it();
  int injected = 0, survived = 0;
  for (int without = 0, n = 1; without < 3; ++n) {
    bool happened = false;
    {
      const test::FailingAllocation failing(n);
      try {
        all_of_it();
        ++survived;
      } catch (const std::runtime_error&) {
        // The failed allocation may have ended the connection or the session.
      }
      happened = failing.happened();
    }
    without = happened ? 0 : without + 1;
    injected += happened ? 1 : 0;
    // A request of a lost connection, such as a reload, may still run.
    std::string wrong;
    const auto all_is_well = [&] {
      try {
        all_of_it();
        return true;
      } catch (const std::runtime_error& error) {
        wrong = error.what();
        return false;
      }
    };
    ASSERT_TRUE(test::becomes(all_is_well)) << wrong << " after allocation " << n;
  }
  std::printf("%d allocations failed in turn\n", injected);
  RecordProperty("injected", injected);
  EXPECT_GT(injected, 50);
}
#endif

}  // namespace
}  // namespace feltwire::exception_test
