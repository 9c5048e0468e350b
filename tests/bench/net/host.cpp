#include "tests/bench/net/host.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <asio/ip/address.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "core/base/splitmix.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/recording/recorder.hpp"
#include "server/scene/scene_host.hpp"
#include "server/web/web_server.hpp"
#include "tests/bench/net/echo.hpp"
#include "tests/bench/net/machine.hpp"

namespace feltwire::netbench {
namespace {

constexpr double kNoLimit =
    1e9;  // times the servo rate; a saturating client sends as fast as possible
constexpr Nanoseconds kBoundedSpin = std::chrono::microseconds(50);

/// Returns ids with 56 random bits above the scene's number, as in the server.
std::vector<std::uint64_t> session_ids(int clients, std::uint64_t scene) {
  std::vector<std::uint64_t> ids;
  for (int i = 0; i < clients; ++i)
    ids.push_back(splitmix::draw(scene, static_cast<std::uint64_t>(i)) << 8 | scene);
  return ids;
}

void write_all(int file, const void* bytes, std::size_t size) {
  if (::write(file, bytes, size) != static_cast<ssize_t>(size)) std::_Exit(1);
}

/// Sends the port and the sessions of a scene to the waiting parent.
void announce(int pipe, std::uint16_t port, const std::vector<std::uint64_t>& ids) {
  write_all(pipe, &port, sizeof port);
  write_all(pipe, ids.data(), ids.size() * sizeof ids[0]);
}

[[noreturn]] void run_echo(const HostOptions& options, int pipe) {
  pin_to(options.cores.front());
  const Socket socket;
  announce(pipe, socket.port(), session_ids(options.clients, 0));
  echo(socket.file(), static_cast<EchoKind>(options.kind));
}

void join_all(SceneHost& host, const std::vector<std::uint64_t>& ids, const HostOptions& options) {
  asio::io_context answers{1};
  std::size_t joined = 0;
  const auto count = [&](const control::Message& message) {
    if (const auto* no = std::get_if<control::Refused>(&message)) {
      std::fprintf(stderr, "feltwire-netbench: %s\n", no->reason.c_str());
      std::_Exit(1);
    }
    ++joined;
  };
  for (const std::uint64_t id : ids)
    host.ask(join_request(options.redundancy), id, session_keys(id, options.suite), answers, count);
  while (joined < ids.size()) {
    answers.restart();
    answers.run_for(std::chrono::milliseconds(1));
  }
}

std::vector<SceneInView*> pointers(const std::vector<std::unique_ptr<SceneHost>>& hosts) {
  std::vector<SceneInView*> result;
  for (const auto& host : hosts) result.push_back(host.get());
  return result;
}

/// Returns the recorder, or null if nothing is recorded.
std::unique_ptr<Recorder> recorder_of(const HostOptions& options) {
  if (options.record.empty()) return nullptr;
  std::vector<Scene> scenes;  // A recording contains the files of the scene.
  scenes.push_back(load_scene_and_keep(options.scene_file));
  return std::make_unique<Recorder>(RecorderOptions{.file = options.record}, scenes);
}

/// Records until the parent requests the complete file.
[[noreturn]] void record_to_the_end(SceneHost& host, Recorder& recorder, int core, int pipe) {
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  pin_to(core);
  recorder.start();
  int signal = 0;
  sigwait(&end, &signal);
  host.stop();
  recorder.stop();
  const std::uint64_t lost = recorder.log(0).lost();
  write_all(pipe, &lost, sizeof lost);
  std::_Exit(0);
}

[[noreturn]] void run_ours(const HostOptions& options, const Tokens& tokens, int pipe) {
  const std::unique_ptr<Recorder> recorder = recorder_of(options);
  // sigwait() needs blocked signals in all threads, before the first thread starts.
  if (recorder != nullptr) {
    sigset_t end;
    sigemptyset(&end);
    sigaddset(&end, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &end, nullptr);
  }
  SceneHostOptions host_options;
  host_options.address = asio::ip::address_v4::loopback();
  host_options.silence_timeout = std::chrono::hours(1);
  host_options.limits.sample_rate = kNoLimit;
  host_options.max_sessions = static_cast<std::size_t>(options.clients);
  host_options.real_time = options.kind == HostKind::ours_real_time;
  if (options.kind == HostKind::ours_bounded) host_options.busy_poll = kBoundedSpin;
  if (options.kind == HostKind::ours_spinning) host_options.busy_poll = kForever;
  std::vector<std::unique_ptr<SceneHost>> hosts;
  for (std::size_t i = 0; i < options.cores.size(); ++i) {
    host_options.events = recorder != nullptr && i == 0 ? &recorder->log(0) : nullptr;
    hosts.push_back(std::make_unique<SceneHost>(load_scene(options.scene_file), host_options));
    if (host_options.events != nullptr) recorder->see(0, hosts.back()->recorded_pictures());
    pin_to(options.cores[i]);  // The host's thread inherits this core.
    hosts.back()->start();
    const auto ids = session_ids(options.clients, i);
    join_all(*hosts.back(), ids, options);
    announce(pipe, hosts.back()->port(), ids);
  }
  std::unique_ptr<web::WebServer> page;
  if (options.page_core >= 0) {
    web::WebOptions web_options;
    web_options.address = asio::ip::address_v4::loopback();
    const std::vector<SceneInView*> scenes = pointers(hosts);
    page = std::make_unique<web::WebServer>(web_options, scenes, TokenFile(tokens),
                                            Identity{});  // Loopback needs no certificate.
    pin_to(options.page_core);
    page->start();
    const std::uint16_t port = page->port();
    write_all(pipe, &port, sizeof port);
  }
  if (recorder != nullptr)
    record_to_the_end(*hosts.front(), *recorder, options.recorder_core, pipe);
  while (true) ::pause();
}

[[noreturn]] void run_child(const HostOptions& options, const Tokens& tokens, int pipe) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    if (ours(options.kind)) run_ours(options, tokens, pipe);
    run_echo(options, pipe);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-netbench: %s\n", error.what());
  }
  std::_Exit(1);
}

void read_all(int file, void* bytes, std::size_t size) {
  auto* at = static_cast<std::uint8_t*>(bytes);
  while (size > 0) {
    const ssize_t got = ::read(file, at, size);
    if (got <= 0) throw std::runtime_error("the server's process ended before it was ready");
    at += got;
    size -= static_cast<std::size_t>(got);
  }
}

}  // namespace

const char* name(HostKind kind) {
  constexpr const char* kNames[] = {"echo, blocking",        "echo, poll + recvmmsg",
                                    "echo, spinning",        "feltwire, sleeping",
                                    "feltwire, spins 50 us", "feltwire, spinning",
                                    "feltwire, --real-time"};
  return kNames[static_cast<std::size_t>(kind)];
}

control::JoinRequest join_request(int redundancy) {
  SessionParameters parameters;
  parameters.redundancy = redundancy;
  parameters.side = BoundingSide::both;  // The server also bounds.
  return {"netbench", "room", builtin_device("simulated"), parameters};
}

SessionKeys session_keys(std::uint64_t session, CipherSuite suite) {
  SessionKeys keys{.suite = suite};
  for (std::size_t i = 0; i < kKeySize; ++i) {
    keys.up[i] = static_cast<std::uint8_t>(splitmix::draw(session, i));
    keys.down[i] = static_cast<std::uint8_t>(splitmix::draw(~session, i));
  }
  return keys;
}

HostProcess::HostProcess(const HostOptions& options) : record_(options.record) {
  const IssuedToken viewers = issue_token("viewers", "*", Role::observer, std::nullopt);
  viewers_token_ = viewers.text.text();
  int pipe[2];
  if (::pipe(pipe) != 0) throw std::runtime_error("no pipe");
  process_ = ::fork();
  if (process_ < 0) throw std::runtime_error("no process");
  if (process_ == 0) run_child(options, {viewers.token}, pipe[1]);
  ::close(pipe[1]);
  targets_.resize(options.cores.size());
  for (Target& target : targets_) {
    target.sessions.resize(static_cast<std::size_t>(options.clients));
    read_all(pipe[0], &target.port, sizeof target.port);
    read_all(pipe[0], target.sessions.data(), target.sessions.size() * sizeof(std::uint64_t));
  }
  if (options.page_core >= 0) read_all(pipe[0], &page_port_, sizeof page_port_);
  pipe_ = pipe[0];
}

Recorded HostProcess::finish() {
  ::kill(process_, SIGTERM);
  Recorded recorded;
  read_all(pipe_, &recorded.lost, sizeof recorded.lost);
  recorded.bytes = std::filesystem::file_size(record_);
  return recorded;
}

HostProcess::~HostProcess() {
  ::close(pipe_);
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

}  // namespace feltwire::netbench
