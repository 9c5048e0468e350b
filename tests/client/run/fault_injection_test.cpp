// Makes each allocation and each thread creation of the client fail in turn, in process. The client
// must release the hand and end the run in order. tests/fault has an equal test of the complete
// programs.

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <pthread.h>

#include <cerrno>
#include <cstdlib>
#include <limits>
#include <new>
#include <optional>

#include "client/run/out_of_memory_reserve.hpp"
#include "client/run/output_files.hpp"
#include "client/run/report.hpp"
#include "client/run/supervise_session.hpp"
#include "client/run/terminal_outlet.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/security.hpp"

namespace feltwire::fault_injection_test {
namespace {

constexpr long kNever = std::numeric_limits<long>::max();
/// Counts allocations in this thread and in each new thread, until an allocation fails.
thread_local long left = kNever;
std::atomic<long> left_of_new_threads{kNever};
std::atomic<int> threads_refused{0};
std::atomic<bool> failed_once{false};

bool fails() noexcept {
  if (left == kNever || --left >= 0) return false;
  left = kNever;
  failed_once.store(true);
  return true;
}

}  // namespace
}  // namespace feltwire::fault_injection_test

namespace test_of = feltwire::fault_injection_test;

[[gnu::noinline]] void* operator new(std::size_t size) {
  while (true) {
    void* memory = test_of::fails() ? nullptr : std::malloc(size == 0 ? 1 : size);
    if (memory != nullptr) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace feltwire::fault_injection_test {
namespace {

struct Begin {
  void* (*start)(void*);
  void* argument;
  long left;
};

void* begin_thread(void* what) {
  const Begin begin = *static_cast<Begin*>(what);
  std::free(what);
  left = begin.left;
  return begin.start(begin.argument);
}

}  // namespace
}  // namespace feltwire::fault_injection_test

/// Replaces the system's function. std::thread uses it too.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) noexcept {
  using Create = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static auto* const create = reinterpret_cast<Create*>(::dlsym(RTLD_NEXT, "pthread_create"));
  if (test_of::threads_refused.load() > 0) {
    --test_of::threads_refused;
    return EAGAIN;
  }
  auto* begin = static_cast<test_of::Begin*>(std::malloc(sizeof(test_of::Begin)));
  *begin = {start, argument, test_of::left_of_new_threads.load()};
  return create(thread, attributes, test_of::begin_thread, begin);
}

namespace feltwire::fault_injection_test {
namespace {

using namespace std::chrono_literals;
using testing::ScenePeer;

/// Keeps the last and the largest force.
class Hand final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command& on_hand) noexcept override {
    const double force = on_hand.force().norm();
    told.store(force);
    if (force > largest.load()) largest.store(force);
    return on_hand;
  }
  void release() noexcept override { told.store(0.0); }
  std::atomic<double> told{0.0}, largest{0.0};  // [N] last and largest force

 private:
  DeviceSpec spec_ = builtin_device("simulated");
};

/// A hand gets 3 N, loses its session and finds no other session.
struct LostRun {
  testing::TemporaryFolder folder;
  ScenePeer peer;
  Hand* hand = new Hand;
  std::shared_ptr<ServoTask> task;
  Ring<LiveStatus> statuses{16};
  Ring<SessionAddress> sessions{4};
  std::filesystem::path file;
  Records records{{.recording = RecordingTarget{file}, .view = {}, .observes = false}};
  Signals signals;
  std::optional<Changes> changes;
  std::thread answering;
  std::atomic<bool> over{false};

  explicit LostRun(const char* name) : file(folder / name) {
    SessionParameters p;
    p.mode = "none";
    p.hold_time = 0.2;
    task = std::make_shared<ServoTask>(std::unique_ptr<Device>(hand),
                                       std::make_shared<Transport>(peer.session(), p, false), p,
                                       ServoOptions{});
    task->let_go_after = p.hold_time;
    task->options = {.patience = 100ms, .rejoined = &sessions};
    task->outputs = {.status = &statuses, .record = records.rows()};
    const ServoOptions options;
    changes.emplace(Changes::Client{hand->spec(), p, options, task->transport->port(), {}});
    answering = std::thread([this] { answer(); });
  }
  ~LostRun() {
    over.store(true);
    answering.join();
  }
  LostRun(const LostRun&) = delete;
  LostRun& operator=(const LostRun&) = delete;

  void answer() {
    while (!over.load()) {
      if (!peer.has_datagram()) continue;
      const auto received = peer.receive();
      if (received.kind != DatagramKind::samples) continue;
      if (hand->largest.load() > 0.0 && received.batch.samples[0].index > 100)
        peer.send(GoodbyeReason::shutting_down);
      else
        peer.send(ScenePeer::reply_to(received.batch.samples[0], {.elastic = Vec3(0, 0, 3)}));
    }
  }
  void expect_good_end(ServoThread& thread, long nth) {
    EXPECT_TRUE(thread.end()) << nth;
    EXPECT_EQ(hand->told, 0.0) << nth;
    EXPECT_EQ(hand->largest, 3.0) << nth;
    EXPECT_EQ(task->result.end, EndReason::server_goodbye) << nth;
    if (!records.failed()) {
      EXPECT_GT(testing::text_of(file).size(), 100u) << nth;
    }
  }
};

ServerAccess nobody() {
  const testing::LocalSocket closed(SOCK_STREAM);
  return test::access(closed.port());
}
/// The first waits that it draws are longer than zero, so that no attempt begins at once.
constexpr std::uint64_t kSeed = 1;
control::JoinRequest anyone() { return {"tester", "floor", builtin_device("simulated"), {}}; }

void fail_each_allocation_of_the_main_thread(const char* recording) {
  const ServerAccess access = nobody();
  long points = 0;
  bool reached = true;
  for (long nth = 0; reached; ++nth) {
    LostRun run(recording);
    Reconnector reconnector(access, anyone(), run.sessions, {.first_wait = 10ms});
    Ring<const FetchedScene*> made(1);
    SceneFetch fetch(access, made);
    ServoThread thread(run.task);
    failed_once.store(false);
    left = nth;
    EmergencyKey no_keys(nullptr, -1);
    TerminalOutlet terminal;
    SessionSupervisor session({thread, run.statuses, run.records, *run.changes, reconnector, fetch},
                              0, terminal);
    supervise_session(run.signals, session, no_keys, terminal);
    left = kNever;
    run.expect_good_end(thread, nth);
    EXPECT_GE(reconnector.attempts(), 1u) << nth;
    reached = failed_once.load();
    points += reached ? 1 : 0;
    while (reconnector.asking()) reconnector.look(true, Reconnector::Clock::now());
  }
  EXPECT_GT(points, 10);
  std::printf("%ld allocations of the main thread failed in turn\n", points);
}

TEST(FaultInjection, EachAllocationOfTheMainThreadFailsAndTheRunEndsInOrder) {
  fail_each_allocation_of_the_main_thread("felt.csv");
}
TEST(FaultInjection, EachAllocationOfAnMcapRecordingFailsAndTheRunEndsInOrder) {
  fail_each_allocation_of_the_main_thread("felt.mcap");
}

/// An attempt without memory must not count as a refusal.
TEST(FaultInjection, EachAllocationOfAnAttemptToJoinFailsAndItIsTriedAgain) {
  long points = 0;
  bool reached = true;
  for (long nth = 0; reached; ++nth) {
    testing::ControlPeer peer(
        control::encode(control::Refused{control::RefusalCode::full, "for this reason"}));
    Ring<SessionAddress> sessions(2);
    Reconnector reconnector(peer.access(), anyone(), sessions, {.timeout = 10s, .seed = kSeed});
    failed_once.store(false);
    reconnector.look(false, Reconnector::Clock::time_point{} + 1h);  // draws the first wait
    left_of_new_threads.store(nth);
    reconnector.look(false, Reconnector::Clock::time_point{} + 2h);
    left_of_new_threads.store(kNever);
    while (reconnector.asking()) {
      reconnector.look(false, Reconnector::Clock::time_point{} + 2h);
      std::this_thread::yield();
    }
    ASSERT_EQ(reconnector.refusal(), "") << nth;
    reached = failed_once.load();
    points += reached ? 1 : 0;
  }
  EXPECT_GT(points, 30);
  std::printf("%ld allocations of an attempt failed in turn\n", points);
}

TEST(FaultInjection, AnAttemptThatGetsNoThreadIsTriedAgain) {
  Ring<SessionAddress> sessions(2);
  Reconnector reconnector(nobody(), anyone(), sessions, {.seed = kSeed});
  Reconnector::Clock::time_point now{};
  reconnector.look(false, now);  // draws the first wait
  for (std::uint64_t n = 1; n <= 3; ++n) {
    threads_refused.store(1);
    reconnector.look(false, now += 1h);
    EXPECT_EQ(reconnector.attempts(), n);
    EXPECT_FALSE(reconnector.asking());
    EXPECT_EQ(reconnector.refusal(), "");
    reconnector.look(false, now);  // The reconnector must not retry at once.
    EXPECT_EQ(reconnector.attempts(), n);
  }
  reconnector.look(false, now += 1h);
  EXPECT_TRUE(reconnector.asking());
  while (reconnector.asking()) reconnector.look(true, now);
}

/// `which` 0: the system refuses the stall detector's thread. `which` 1: an allocation for a thread
/// fails.
TEST(FaultInjection, AServoThatGetsNoThreadTellsItsDeviceNothing) {
  for (const int which : {0, 1}) {
    LostRun run("felt.csv");
    run.over.store(true);
    if (which == 0) {
      threads_refused.store(1);
      EXPECT_THROW(ServoThread thread(run.task), std::system_error);
    } else {
      for (long nth = 0;; ++nth) {
        left = nth;
        failed_once.store(false);
        try {
          ServoThread thread(run.task);
          left = kNever;
          EXPECT_FALSE(failed_once.load());
          break;
        } catch (const std::bad_alloc&) {
          EXPECT_EQ(run.hand->largest, 0.0);
        }
        left = kNever;
      }
    }
    EXPECT_EQ(run.hand->told, 0.0);
  }
}

TEST(FaultInjection, EachAllocationOfTheReportFailsAndItIsWrittenAllTheSame) {
  const testing::TemporaryFolder folder;
  const Servo servo(builtin_device("simulated"), {});
  const auto result = std::make_unique<LoopResult>();
  const std::string whole = report_json({}, servo, {}, *result);
  long points = 0;
  for (long nth = 0;; ++nth) {
    OutOfMemoryReserve reserve;
    reserve.stand_in();
    failed_once.store(false);
    left = nth;
    write_whole(folder / "report.json", report_json({}, servo, {}, *result));
    left = kNever;
    ASSERT_EQ(testing::text_of(folder / "report.json"), whole) << nth;
    if (!failed_once.load()) break;
    ++points;
  }
  EXPECT_GT(points, 100);
  std::printf("%ld allocations of a report failed in turn\n", points);
}

TEST(FaultInjection, WhatIsPutByIsGivenBackOnce) {
  OutOfMemoryReserve reserve;
  reserve.stand_in();
  left = 0;
  EXPECT_NO_THROW(::operator delete(::operator new(1)));
  left = 0;
  EXPECT_THROW(::operator delete(::operator new(1)), std::bad_alloc);
  left = kNever;
}

}  // namespace
}  // namespace feltwire::fault_injection_test
