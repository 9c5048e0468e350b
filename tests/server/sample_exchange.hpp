#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::test {

/// The sessions of a scene and a client of each, with a simulated clock. Datagrams with one sample
/// go in, payloads come out.
struct SampleExchange {
  explicit SampleExchange(const Scene& of, std::size_t slots = 4, const SessionLimits& limits = {})
      : scene(of), sessions(scene, std::chrono::seconds(2), slots, nullptr, limits) {}

  /// Sends the next sample of session `id` now; returns the answer's payload, empty if withheld.
  std::vector<std::uint8_t> send(std::uint64_t id, Sample sample, bool rotation) {
    sample.index = ++index[id];
    sample.client_time = now;
    SampleBatch batch;
    batch.count = 1;
    batch.rotation = rotation;
    batch.previous = sample.index - 1;
    batch.samples[0] = sample;
    batch.report = report;
    batch.lead = lead;
    const Bytes datagram = encoder.samples(id, sample.index, batch);
    DatagramBuffer out;
    const std::size_t before = allocations();
    const Bytes answer = sessions.receive(datagram, peer, now, out);
    allocated += allocations() - before;
    length = answer.size();
    return opened(answer, Way::down);
  }

  Scene scene;
  SceneSessions sessions;
  SealedEncoder encoder{Way::up};
  Peer peer{.address = {}, .length = 1};
  Nanoseconds now{std::chrono::seconds(1)};
  std::size_t allocated = 0;  // by the server
  std::size_t length = 0;     // [bytes] of the last payload
  std::map<std::uint64_t, std::uint64_t> index;
  std::optional<HandReport> report;  // sent with the samples
  std::optional<Lead> lead;          // sent with the samples
};

}  // namespace feltwire::test
