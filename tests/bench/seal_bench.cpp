// seal/SUITE, open/SUITE: the seal of a datagram with a payload of 128 bytes.
// receive/CASE: the server's work on a datagram, without system calls. `answered` includes contact,
//   bound and both seals. The other cases are dropped datagrams. Their names are the reasons.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/scene_file/load_scene.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire::seal_bench {
namespace {

constexpr std::uint64_t kSession = 0x700;
constexpr std::size_t kPayload = 128;  // [bytes]
const Key kUp = {1}, kDown = {2};

const char* name(CipherSuite suite) {
  return suite == CipherSuite::aes_256_gcm ? "aes_256_gcm" : "chacha20_poly1305";
}

void seal(benchmark::State& state, CipherSuite suite) {
  Sealer sealer(suite, kUp);
  const std::array<std::uint8_t, kPayload> payload{};
  DatagramBuffer out;
  for (auto _ : state)
    benchmark::DoNotOptimize(sealer.seal(DatagramKind::samples, kSession, payload, out));
}

/// The time includes the replay window's check and mark. The datagrams are made before the clock
/// runs.
void open(benchmark::State& state, CipherSuite suite) {
  constexpr std::size_t kDatagrams = 1024;
  Sealer sealer(suite, kUp);
  const std::array<std::uint8_t, kPayload> payload{};
  std::vector<DatagramBuffer> sealed(kDatagrams);
  Bytes last;
  for (DatagramBuffer& out : sealed)
    last = sealer.seal(DatagramKind::samples, kSession, payload, out);
  const Opener fresh(suite, kUp);
  Opener opener = fresh;
  DatagramBuffer out;
  std::size_t n = 0;
  for (auto _ : state) {
    if (n == kDatagrams) {
      state.PauseTiming();
      opener = fresh;
      n = 0;
      state.ResumeTiming();
    }
    const Bytes datagram = Bytes(sealed[n++].bytes).first(last.size());
    const Guarded guarded = guard(datagram, ~0u);
    benchmark::DoNotOptimize(opener.open(guarded.header, datagram, out));
  }
}

struct Server {
  Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json");
  SceneSessions sessions{scene, std::chrono::hours(1), 64, nullptr, {.sample_rate = 1e6}};
  Encoder encoder;
  Sealer client{preferred_suite(), kUp};
  DatagramBuffer sent, answer;
  SampleBatch batch;

  Server() {
    control::JoinRequest request{"bench", scene.name(), builtin_device("simulated"), {}};
    request.parameters.side = BoundingSide::both;
    sessions.answer(request, kSession, {preferred_suite(), kUp, kDown}, {});
    batch.count = 1;
  }
  /// Returns the next sample of a hand that moves in and out of the room's table.
  Bytes sample() {
    Sample& sample = batch.samples[0];
    ++sample.index;
    const double t = 1e-3 * static_cast<double>(sample.index);
    sample.client_time += std::chrono::milliseconds(1);
    sample.pose.position = {0.05 * std::sin(3 * t), 0.05 * std::cos(2 * t),
                            -0.05075 + 0.00125 * std::sin(11 * t)};
    return client.seal(DatagramKind::samples, kSession, encoder.samples(batch), sent);
  }
};

/// Makes a sample and seals it at the client. Subtract this time from `answered`.
void sample(benchmark::State& state) {
  Server server;
  for (auto _ : state) benchmark::DoNotOptimize(server.sample());
}

void answered(benchmark::State& state) {
  Server server;
  for (auto _ : state)
    benchmark::DoNotOptimize(server.sessions.receive(server.sample(), {}, {}, server.answer));
}

void dropped(benchmark::State& state, DropReason reason) {
  Server server;
  const Bytes first = server.sample();
  std::vector<std::uint8_t> datagram(first.begin(), first.end());
  if (reason == DropReason::session)
    write_header(datagram, {DatagramKind::samples, kSession + 256, 1});
  if (reason == DropReason::sealed) datagram.back() ^= 1;
  if (reason == DropReason::packet_number) server.sessions.receive(datagram, {}, {}, server.answer);
  for (auto _ : state)
    benchmark::DoNotOptimize(server.sessions.receive(datagram, {}, {}, server.answer));
  if (server.sessions.counters().drops[static_cast<std::size_t>(reason)] <
      static_cast<std::uint64_t>(state.iterations()))
    state.SkipWithError("dropped for another reason");
}

const bool registered = [] {
  for (const CipherSuite suite : {CipherSuite::aes_256_gcm, CipherSuite::chacha20_poly1305}) {
    if (!supported(suite)) continue;
    benchmark::RegisterBenchmark((std::string("seal/") + name(suite)).c_str(), seal, suite);
    benchmark::RegisterBenchmark((std::string("open/") + name(suite)).c_str(), open, suite);
  }
  benchmark::RegisterBenchmark("sample", sample);
  benchmark::RegisterBenchmark("receive/answered", answered);
  for (const DropReason reason :
       {DropReason::session, DropReason::packet_number, DropReason::sealed})
    benchmark::RegisterBenchmark((std::string("receive/") + name(reason)).c_str(), dropped, reason);
  return true;
}();

}  // namespace
}  // namespace feltwire::seal_bench
