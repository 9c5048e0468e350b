#include "protocol/wire/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/datagram_generated.h"
#include "tests/protocol/make.hpp"
#include "tests/protocol/misaligned.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::codec_test {
namespace {

using test::Generator;
using test::random_batch;

void expect_same(const Sample& a, const Sample& b) {
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.client_time, b.client_time);
  EXPECT_EQ(a.pose.position, b.pose.position);
  EXPECT_EQ(a.pose.orientation.coeffs(), b.pose.orientation.coeffs());
  EXPECT_EQ(a.held.elastic, b.held.elastic);
  EXPECT_EQ(a.held.frictional, b.held.frictional);
  EXPECT_EQ(a.held.torque, b.held.torque);
}

Reply random_reply(Generator& random) {
  Reply reply;
  reply.sample_index = 1 + random() / 2;
  reply.client_time = Nanoseconds(static_cast<std::int64_t>(random()));
  reply.server_times.received = Nanoseconds(static_cast<std::int64_t>(random()));
  reply.server_times.sent = Nanoseconds(static_cast<std::int64_t>(random()));
  reply.command = {test::vector(random, 20), test::vector(random, 5), Vec3::Zero()};
  reply.rotation = random() % 2 == 0;
  if (reply.rotation) reply.command.torque = test::vector(random, 1);
  reply.delivered = {test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                     test::uniform(random, -1, 1)};
  reply.bound.ratio = static_cast<float>(test::uniform(random, 0, 1));
  const auto flags = random();
  reply.bound.active = flags & 1;
  reply.bound.saturated = flags & 2;
  reply.bound.refused = flags & 4;
  reply.gap = flags & 8;
  reply.recovering = flags & 16;
  reply.reloads = static_cast<std::uint8_t>(random());
  reply.pace = static_cast<std::uint8_t>(1 + random() % 255);
  return reply;
}

TEST(Codec, SamplesRoundTrip) {
  Generator random(1);
  Encoder encoder;
  for (int round = 0; round < 2000; ++round) {
    const int count = 1 + static_cast<int>(random() % 9);
    const SampleBatch sent = random_batch(random, 100 + random() % 1000, count, random() % 2 == 0);
    const Bytes payload = encoder.samples(sent);
    ASSERT_LE(payload.size(), kMaxPayload);
    SampleBatch received;
    ASSERT_EQ(decode(payload, received), DropReason::none);
    ASSERT_EQ(received.count, sent.count);
    EXPECT_EQ(received.rotation, sent.rotation);
    for (int i = 0; i < count; ++i)
      expect_same(received.samples[static_cast<std::size_t>(i)],
                  sent.samples[static_cast<std::size_t>(i)]);
  }
}

/// Decoding into a batch must keep nothing of its former content.
TEST(Codec, SamplesWithoutRotationsAreUpright) {
  Generator random(2);
  Encoder encoder;
  SampleBatch received = random_batch(random, 50, 9, true);
  ASSERT_EQ(decode(encoder.samples(random_batch(random, 9, 3, false)), received), DropReason::none);
  EXPECT_FALSE(received.rotation);
  EXPECT_EQ(received.count, 3);
  for (const Sample& sample : received.view()) {
    EXPECT_EQ(sample.pose.orientation.coeffs(), Quaternion::Identity().coeffs());
    EXPECT_EQ(sample.held.torque, Vec3::Zero());
  }
}

TEST(Codec, ReplyRoundTrip) {
  Generator random(3);
  Encoder encoder;
  for (int round = 0; round < 2000; ++round) {
    const Reply sent = random_reply(random);
    const Bytes payload = encoder.reply(sent);
    EXPECT_LE(payload.size() + kOverhead, 256u);
    Reply received = random_reply(random);
    ASSERT_EQ(decode(payload, received), DropReason::none);
    EXPECT_EQ(received.sample_index, sent.sample_index);
    EXPECT_EQ(received.client_time, sent.client_time);
    EXPECT_EQ(received.server_times.received, sent.server_times.received);
    EXPECT_EQ(received.server_times.sent, sent.server_times.sent);
    EXPECT_EQ(received.command.elastic, sent.command.elastic);
    EXPECT_EQ(received.command.frictional, sent.command.frictional);
    EXPECT_EQ(received.command.torque, sent.command.torque);
    EXPECT_EQ(received.rotation, sent.rotation);
    EXPECT_EQ(received.delivered.elastic, sent.delivered.elastic);
    EXPECT_EQ(received.delivered.frictional, sent.delivered.frictional);
    EXPECT_EQ(received.delivered.torque, sent.delivered.torque);
    EXPECT_EQ(received.bound.ratio, sent.bound.ratio);
    EXPECT_EQ(received.bound.active, sent.bound.active);
    EXPECT_EQ(received.bound.saturated, sent.bound.saturated);
    EXPECT_EQ(received.bound.refused, sent.bound.refused);
    EXPECT_EQ(received.gap, sent.gap);
    EXPECT_EQ(received.recovering, sent.recovering);
    EXPECT_EQ(received.reloads, sent.reloads);
    EXPECT_EQ(received.pace, sent.pace);
  }
}

// Checks each bit of PROTOCOL.md.
TEST(Codec, TheFlagsOfAReplyAreTheProtocols) {
  Encoder encoder;
  const std::vector<bool& (*)(Reply&)> flags = {[](Reply& r) -> bool& { return r.bound.active; },
                                                [](Reply& r) -> bool& { return r.bound.saturated; },
                                                [](Reply& r) -> bool& { return r.bound.refused; },
                                                [](Reply& r) -> bool& { return r.gap; },
                                                [](Reply& r) -> bool& { return r.recovering; }};
  for (std::size_t bit = 0; bit < flags.size(); ++bit) {
    Reply reply;
    reply.sample_index = 1;
    flags[bit](reply) = true;
    const Bytes payload = encoder.reply(reply);
    EXPECT_EQ(flatbuffers::GetRoot<wire::Reply>(payload.data())->report()->flags(), 1u << bit);
    Reply received;
    ASSERT_EQ(decode(payload, received), DropReason::none);
    for (std::size_t other = 0; other < flags.size(); ++other)
      EXPECT_EQ(flags[other](received), other == bit);
  }
}

TEST(Codec, GoodbyeRoundTrip) {
  Encoder encoder;
  for (const auto reason :
       {GoodbyeReason::leaving, GoodbyeReason::shutting_down, GoodbyeReason::evicted,
        GoodbyeReason::flooding, GoodbyeReason::failed, GoodbyeReason::disturbing}) {
    GoodbyeReason received = GoodbyeReason::leaving;
    EXPECT_EQ(decode(encoder.goodbye(reason), received), DropReason::none);
    EXPECT_EQ(received, reason);
  }
}

TEST(Codec, SizesKeepTheirPromises) {
  Generator random(4);
  Encoder encoder;
  EXPECT_LE(encoder.samples(random_batch(random, 9, 1, true)).size() + kOverhead, 256u);
  EXPECT_LE(encoder.samples(random_batch(random, 9, 9, true)).size(), kMaxPayload);
}

TEST(Codec, PayloadMayLieAnywhere) {
  Generator random(5);
  Encoder encoder;
  const SampleBatch sent = random_batch(random, 77, 4, true);
  const Bytes payload = encoder.samples(sent);
  for (std::size_t shift = 0; shift < 8; ++shift) {
    std::vector<std::uint8_t> moved(shift, 0);
    moved.insert(moved.end(), payload.begin(), payload.end());
    SampleBatch received;
    ASSERT_EQ(decode(Bytes(moved).subspan(shift), received), DropReason::none);
    expect_same(received.samples[3], sent.samples[3]);
  }
}

// Tests each refusal of the codec itself.

DropReason verdict(const SampleBatch& batch) {
  Encoder encoder;
  SampleBatch out;
  return decode(encoder.samples(batch), out);
}

TEST(CodecDrops, Count) {
  Generator random(6);
  EXPECT_EQ(verdict(random_batch(random, 9, 0, false)), DropReason::count);

  // The test builds payloads that the encoder refuses.
  for (const auto& [samples, rotations] : {std::pair{10u, 0u}, {3u, 2u}, {1u, 9u}}) {
    flatbuffers::FlatBufferBuilder builder;
    std::vector<wire::Sample> s;
    for (unsigned i = 0; i < samples; ++i)
      s.emplace_back(100 - i, 0, wire::Vec3d(0, 0, 0), wire::Vec3f(0, 0, 0), wire::Vec3f(0, 0, 0));
    const std::vector<wire::Rotation> r(
        rotations, wire::Rotation(wire::Quatd(1, 0, 0, 0), wire::Vec3f(0, 0, 0)));
    const auto sv = builder.CreateVectorOfStructs(s);
    const auto rv = builder.CreateVectorOfStructs(r);
    builder.Finish(rotations == 0 ? wire::CreateSamples(builder, sv)
                                  : wire::CreateSamples(builder, sv, rv));
    SampleBatch out;
    EXPECT_EQ(decode({builder.GetBufferPointer(), builder.GetSize()}, out), DropReason::count);
  }
}

TEST(CodecDrops, Order) {
  Generator random(7);
  SampleBatch batch = random_batch(random, 9, 3, false);
  batch.samples[1].index = 9;
  EXPECT_EQ(verdict(batch), DropReason::order);
  batch.samples[1].index = 10;
  EXPECT_EQ(verdict(batch), DropReason::order);
  EXPECT_EQ(verdict(random_batch(random, 0, 1, false)), DropReason::order);
}

TEST(CodecDrops, NotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(Sample&)>> spoils = {
      [=](Sample& s) { s.pose.position.x() = nan; },
      [=](Sample& s) { s.pose.position.y() = nan; },
      [=](Sample& s) { s.pose.position.z() = -inf; },
      [](Sample& s) { s.pose.position.y() = 1000.1; },
      [=](Sample& s) { s.held.elastic.x() = nan; },
      [=](Sample& s) { s.held.frictional.z() = inf; },
      [](Sample& s) { s.held.elastic.y() = 1e39; },  // infinite as float32
      [=](Sample& s) { s.held.torque.y() = nan; },
      [=](Sample& s) { s.pose.orientation.w() = nan; },
      [](Sample& s) { s.pose.orientation.coeffs() *= 1.01; },
      [](Sample& s) { s.pose.orientation.coeffs().setZero(); },
  };
  Generator random(8);
  for (std::size_t which = 0; which < spoils.size(); ++which) {
    for (std::size_t at = 0; at < 3; ++at) {
      SampleBatch batch = random_batch(random, 9, 3, true);
      ASSERT_EQ(verdict(batch), DropReason::none);
      spoils[which](batch.samples[at]);
      EXPECT_EQ(verdict(batch), DropReason::not_finite) << "spoil " << which << " at " << at;
    }
  }
}

TEST(CodecDrops, ReplyThatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Encoder encoder;
  Reply out;
  Reply reply;
  EXPECT_EQ(decode(encoder.reply(reply), out), DropReason::order);  // index 0
  reply.sample_index = 1;
  EXPECT_EQ(decode(encoder.reply(reply), out), DropReason::none);
  for (double* number : {&reply.command.elastic.x(), &reply.command.frictional.y(),
                         &reply.bound.ratio, &reply.delivered.torque, &reply.delivered.elastic}) {
    const double before = *number;
    *number = nan;
    EXPECT_EQ(decode(encoder.reply(reply), out), DropReason::not_finite);
    *number = before;
  }
  reply.rotation = true;
  reply.command.torque.z() = nan;
  EXPECT_EQ(decode(encoder.reply(reply), out), DropReason::not_finite);
}

TEST(CodecDrops, OneKindIsNotAnother) {
  Generator random(9);
  Encoder encoder;
  SampleBatch batch;
  Reply reply;
  GoodbyeReason reason;
  EXPECT_EQ(decode(encoder.goodbye(GoodbyeReason::evicted), batch), DropReason::malformed);
  EXPECT_EQ(decode(encoder.samples(random_batch(random, 5, 2, false)), reply),
            DropReason::malformed);
  flatbuffers::FlatBufferBuilder builder;
  builder.Finish(wire::CreateGoodbye(builder, static_cast<wire::GoodbyeReason>(6)));
  EXPECT_EQ(decode({builder.GetBufferPointer(), builder.GetSize()}, reason), DropReason::malformed);
}

/// FlatBuffers' verifier accepts misaligned numbers, but reading them is undefined.
TEST(CodecDrops, NumbersOutOfPlace) {
  Generator random(4);
  Encoder encoder;
  const Bytes sent = encoder.samples(random_batch(random, 9, 2, true));
  const std::vector<std::uint8_t> bytes(sent.begin(), sent.end());
  const auto* root = flatbuffers::GetRoot<wire::Samples>(bytes.data());
  SampleBatch batch;
  ASSERT_EQ(decode(bytes, batch), DropReason::none);
  const auto expect_malformed = [&](flatbuffers::voffset_t field, std::size_t size) {
    const auto moved = test::with_misaligned_vector(bytes, bytes.data(), root, field, size);
    flatbuffers::Verifier verifier(moved.data(), moved.size());
    ASSERT_TRUE(verifier.VerifyBuffer<wire::Samples>(nullptr));
    EXPECT_EQ(decode(moved, batch), DropReason::malformed);
  };
  expect_malformed(wire::Samples::VT_SAMPLES, 2 * sizeof(wire::Sample));
  expect_malformed(wire::Samples::VT_ROTATIONS, 2 * sizeof(wire::Rotation));
}

TEST(CodecDrops, EverySizeThatIsNone) {
  SampleBatch batch;
  Reply reply;
  GoodbyeReason reason;
  for (std::size_t size : {0u, 1u, 7u, 8u, 100u, 1200u, 1201u, 70000u}) {
    for (const std::uint8_t fill : {std::uint8_t{0x00}, std::uint8_t{0xff}, std::uint8_t{0x04}}) {
      const std::vector<std::uint8_t> bytes(size, fill);
      EXPECT_EQ(decode(Bytes(bytes), batch), DropReason::malformed);
      EXPECT_EQ(decode(Bytes(bytes), reply), DropReason::malformed);
      if (fill != 0 && size != 0) {
        EXPECT_EQ(decode(Bytes(bytes), reason), DropReason::malformed);
      }
    }
  }
}

/// Any bytes must cause no crash and no allocation. A payload that passes must be usable.
void expect_harmless(Bytes payload) {
  const std::size_t before = test::allocations();
  SampleBatch batch;
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;
  const DropReason samples = decode(payload, batch);
  const DropReason replied = decode(payload, reply);
  const DropReason goodbye = decode(payload, reason);
  ASSERT_EQ(test::allocations(), before);
  if (samples == DropReason::none) {
    ASSERT_GE(batch.count, 1);
    ASSERT_LE(batch.count, kMaxRedundancy + 1);
    for (const Sample& sample : batch.view()) {
      ASSERT_TRUE(sample.pose.position.allFinite());
      ASSERT_TRUE(sample.held.finite());
    }
  }
  if (replied == DropReason::none) {
    ASSERT_TRUE(reply.command.finite());
  }
  if (goodbye == DropReason::none) {
    ASSERT_LE(static_cast<int>(reason), 5);
  }
}

TEST(CodecFuzz, RandomBytes) {
  for (const std::uint64_t seed : test::seeds(10, 1, 1)) {
    Generator random(seed);
    std::vector<std::uint8_t> bytes;
    for (int round = 0; round < 10'000; ++round) {
      bytes.resize(random() % 1300);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
      if (bytes.size() >= 4 && round % 2 == 0)  // a plausible root offset
        bytes[1] = bytes[2] = bytes[3] = 0;
      expect_harmless(bytes);
    }
  }
}

TEST(CodecFuzz, TruncationsAndBitFlipsOfValidPayloads) {
  Generator random(11);
  Encoder encoder;
  for (int round = 0; round < 60; ++round) {
    Bytes valid;
    if (round % 3 == 0)
      valid = encoder.reply(random_reply(random));
    else if (round % 3 == 1)
      valid = encoder.samples(random_batch(random, 99, 1 + round % 9, round % 2 == 0));
    else
      valid = encoder.goodbye(GoodbyeReason::leaving);
    std::vector<std::uint8_t> bytes(valid.begin(), valid.end());
    for (std::size_t size = 0; size <= bytes.size(); ++size)
      expect_harmless(
          std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + static_cast<long>(size)));
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
      expect_harmless(bytes);
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    }
    for (int flips = 0; flips < 200; ++flips) {
      std::vector<std::uint8_t> spoiled = bytes;
      for (int i = 0; i < 8; ++i)
        spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
      expect_harmless(spoiled);
    }
  }
}

TEST(CodecAllocation, NoneOnceTheEncoderIsMade) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  Generator random(12);
  Encoder encoder;
  SampleBatch batch = random_batch(random, 20'000, 9, true);
  Reply reply = random_reply(random);
  SampleBatch batch_out;
  Reply reply_out;

  const std::size_t before = test::allocations();
  DropReason worst = DropReason::none;
  for (std::uint64_t i = 1; i <= 10'000; ++i) {
    batch.count = 1 + static_cast<int>(i % 9);
    worst = std::max(worst, decode(encoder.samples(batch), batch_out));
    worst = std::max(worst, decode(encoder.reply(reply), reply_out));
    encoder.goodbye(GoodbyeReason::leaving);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(worst, DropReason::none);

  const std::size_t counting = test::allocations();
  ::operator delete(::operator new(1));  // The counter must work.
  EXPECT_EQ(test::allocations(), counting + 2);
}

}  // namespace
}  // namespace feltwire::codec_test
