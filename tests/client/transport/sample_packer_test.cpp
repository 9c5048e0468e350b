// The packer selects the samples to send, by packet_interval and by the deadband.

#include "client/transport/sample_packer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <vector>

#include "protocol/wire/codec.hpp"

namespace feltwire::sample_packer_test {
namespace {

using ::testing::ElementsAre;

constexpr Nanoseconds kTick = std::chrono::milliseconds(1);
constexpr double kPeriod = 1e-3;  // [s]

Sample sample(std::uint64_t index, const Vec3& position = Vec3::Zero()) {
  Sample s;
  s.index = index;
  s.client_time = static_cast<std::int64_t>(index) * kTick;
  s.pose.position = position;
  return s;
}

SessionParameters traffic(int interval, int batch, int redundancy) {
  SessionParameters p;
  p.packet_interval = interval;
  p.batch = batch;
  p.redundancy = redundancy;
  validate(p);
  return p;
}

SessionParameters deadband(double fraction, double keep_alive = 0.02) {
  SessionParameters p;
  p.position_deadband = fraction;
  p.keep_alive = keep_alive;
  validate(p);
  return p;
}

std::vector<std::uint64_t> indices(const SampleBatch& batch) {
  std::vector<std::uint64_t> all;
  for (const Sample& s : batch.view()) all.push_back(s.index);
  return all;
}

/// The ticks at which a datagram was made.
std::vector<std::uint64_t> sent(SamplePacker& packer, std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> ticks;
  for (std::uint64_t index = first; index <= last; ++index)
    if (packer.add(sample(index)) != nullptr) ticks.push_back(index);
  return ticks;
}

TEST(SamplePacker, SendsAtThePaceThatTheServerAsksFor) {
  SamplePacker packer(traffic(2, 2, 1), false);
  EXPECT_THAT(sent(packer, 1, 6), ElementsAre(1, 3, 5));
  packer.set_pace(2);
  EXPECT_THAT(sent(packer, 7, 14), ElementsAre(9, 13));
  const SampleBatch* batch = packer.add(sample(15));
  EXPECT_EQ(batch, nullptr);
  packer.set_pace(1);
  batch = packer.add(sample(16));
  ASSERT_NE(batch, nullptr);
  EXPECT_THAT(indices(*batch), ElementsAre(16, 15, 13)) << "the newest, and a repeated one";
  packer.set_pace(4);
  packer.restart();
  EXPECT_EQ(packer.pace(), 1);
}

/// Answers must come while the hand still holds the last one.
TEST(SamplePacker, ThePaceHasALimit) {
  SessionParameters p = traffic(1, 1, 0);
  SamplePacker usual(p, false);
  usual.set_pace(255);
  EXPECT_EQ(usual.pace(), 10) << "10 ms";
  usual.set_pace(0);
  EXPECT_EQ(usual.pace(), 1);
  p.hold_time = 0.02;
  SamplePacker short_hold(p, false);
  short_hold.set_pace(255);
  EXPECT_EQ(short_hold.pace(), 5) << "a quarter of the hold time";
  SamplePacker slow(traffic(20, 1, 0), false);
  slow.set_pace(255);
  EXPECT_EQ(slow.pace(), 1) << "it sends less than every 10 ms anyway";
}

TEST(SamplePacker, AnotherSwitchOrSeatTravelsAtOnce) {
  SamplePacker packer(traffic(100, 1, 0), false);
  EXPECT_NE(packer.add(sample(1), {}, Lead{}), nullptr);
  EXPECT_EQ(packer.add(sample(2), {}, Lead{.known_surface = 7}), nullptr);
  std::uint64_t index = 3;
  for (const auto seat : std::vector<std::uint8_t>{1, 2, 0}) {
    EXPECT_NE(packer.add(sample(index++), {}, Lead{.seat = seat}), nullptr);
    EXPECT_EQ(packer.add(sample(index++), {}, Lead{.seat = seat}), nullptr);
  }
  EXPECT_NE(packer.add(sample(index), {}, Lead{.deadman = true}), nullptr);
}

TEST(SamplePacker, TheFirstSampleTravelsAtOnceThenEveryNth) {
  SamplePacker packer(traffic(5, 1, 2), false);
  const SampleBatch* batch = packer.add(sample(1));
  ASSERT_NE(batch, nullptr);
  EXPECT_THAT(indices(*batch), ElementsAre(1u));
  EXPECT_EQ(batch->previous, 0u);
  for (std::uint64_t i = 2; i <= 21; ++i) {
    batch = packer.add(sample(i));
    ASSERT_EQ(batch != nullptr, i % 5 == 1) << i;
    if (i == 6) {
      EXPECT_THAT(indices(*batch), ElementsAre(6u, 1u));
    }
    if (i == 6 || i == 11) {
      EXPECT_EQ(batch->previous, 0u);
    }
    if (i == 16) {
      EXPECT_THAT(indices(*batch), ElementsAre(16u, 11u, 6u));
    }
    if (i == 16) {
      EXPECT_EQ(batch->previous, 1u);
    }
  }
}

TEST(SamplePacker, ABatchIsEvenlySpacedWithTheNewest) {
  SamplePacker packer(traffic(10, 5, 4), false);
  packer.add(sample(1));
  const SampleBatch* batch = nullptr;
  for (std::uint64_t i = 2; i <= 21; ++i) {
    batch = packer.add(sample(i));
    if (i == 11) {
      EXPECT_THAT(indices(*batch), ElementsAre(11u, 9u, 7u, 5u, 3u, 1u));
    }
  }
  ASSERT_NE(batch, nullptr);
  EXPECT_THAT(indices(*batch), ElementsAre(21u, 19u, 17u, 15u, 13u, 11u, 9u, 7u, 5u));
  EXPECT_EQ(batch->previous, 3u);
}

/// All parameters must satisfy the codec's checks and PROTOCOL.md.
TEST(SamplePacker, EveryTrafficKeepsTheProtocol) {
  for (int interval : {1, 2, 3, 7, 20})
    for (int batch = 1; batch <= std::min(interval, kMaxRedundancy + 1); ++batch)
      for (int redundancy = 0; redundancy + batch <= kMaxRedundancy + 1; ++redundancy)
        for (const double fraction : {0.0, 0.1}) {
          SessionParameters p = traffic(interval, batch, redundancy);
          p.position_deadband = fraction;
          p.keep_alive = 0.05;
          SamplePacker packer(p, false);
          std::vector<std::uint64_t> travelled;  // ascending sample indices
          for (std::uint64_t i = 1; i <= 300; ++i) {
            const Vec3 position(0.05 * std::sin(0.02 * static_cast<double>(i)), 0, 0);
            const SampleBatch* made = packer.add(sample(i, position));
            if (made == nullptr) continue;
            ASSERT_EQ(check(*made), DropReason::none);
            const auto all = indices(*made);
            ASSERT_EQ(all.front(), i);
            if (!travelled.empty()) {
              ASSERT_GE(i - travelled.back(), static_cast<unsigned>(interval));
            }
            // A batch begins with its new samples. The newest known samples follow without a gap.
            std::size_t fresh = 0;
            while (fresh < all.size() && (travelled.empty() || all[fresh] > travelled.back()))
              ++fresh;
            ASSERT_EQ(fresh, static_cast<std::size_t>(i == 1 ? 1 : batch));
            const std::size_t again =
                std::min(travelled.size(), static_cast<std::size_t>(redundancy));
            ASSERT_EQ(all.size(), fresh + again);
            for (std::size_t j = 0; j < again; ++j)
              ASSERT_EQ(all[fresh + j], travelled[travelled.size() - 1 - j]);
            ASSERT_EQ(made->previous,
                      travelled.size() > again ? travelled[travelled.size() - 1 - again] : 0u);
            travelled.insert(travelled.end(), all.rend() - static_cast<std::ptrdiff_t>(fresh),
                             all.rend());
          }
        }
}

TEST(SamplePacker, ANewSessionHasMissedNothing) {
  SamplePacker packer(traffic(3, 2, 3), false);
  for (std::uint64_t i = 1; i <= 9; ++i) packer.add(sample(i));
  packer.restart();
  const SampleBatch* batch = packer.add(sample(10));
  ASSERT_NE(batch, nullptr);
  EXPECT_THAT(indices(*batch), ElementsAre(10u));
  EXPECT_EQ(batch->previous, 0u);
  packer.add(sample(11));
  packer.add(sample(12));
  batch = packer.add(sample(13));
  EXPECT_THAT(indices(*batch), ElementsAre(13u, 12u, 10u));
}

/// Returns the indices of the sent samples of a movement.
std::set<std::uint64_t> sent(const SessionParameters& p, const PositionScale& scale,
                             const std::function<Sample(std::uint64_t)>& at, int count,
                             bool rotation = false) {
  SamplePacker packer(p, rotation, scale);
  std::set<std::uint64_t> all;
  for (std::uint64_t i = 1; i <= static_cast<std::uint64_t>(count); ++i)
    if (packer.add(at(i)) != nullptr) all.insert(i);
  return all;
}

TEST(PositionDeadband, AHandAtRestIsHeardOfOnceAKeepAlive) {
  const PositionScale scale{1e-5, 1000.0};
  // The hand rests at the border between two encoder steps.
  const auto rest = [](std::uint64_t i) {
    return sample(i, Vec3(0, 0, 1e-5 * static_cast<double>(i % 2)));
  };
  const auto all = sent(deadband(0.1, 0.02), scale, rest, 1001);
  std::uint64_t last = 1;
  for (const std::uint64_t i : all) {
    EXPECT_LE(i - last, 20u);
    last = i;
  }
  EXPECT_EQ(all.size(), 51u);
}

/// In free space the level predictor sends the next sample k tau after the last sample, at any
/// speed.
TEST(PositionDeadband, InFreeSpaceTheServerIsLateByKTau) {
  for (const double k : {0.13, 0.22, 0.47})
    for (const double speed : {0.05, 0.5}) {
      const auto move = [&](std::uint64_t i) {
        return sample(i, Vec3(speed * kPeriod * static_cast<double>(i), 0, 0));
      };
      const auto all = sent(deadband(k, 0.05), {1e-6, 1000.0}, move, 2000);
      const auto allowed =
          static_cast<std::uint64_t>(std::floor(k * SamplePacker::kFreeAge / kPeriod + 1e-6)) + 1;
      std::uint64_t last = 1;
      for (const std::uint64_t i : all) {
        EXPECT_LE(i - last, allowed);
        last = i;
      }
      EXPECT_NEAR(static_cast<double>(all.size()), 2000.0 / static_cast<double>(allowed), 3.0) << k;
    }
}

/// The unsent movement must change the force by at most a fraction k of the felt force.
TEST(PositionDeadband, InContactTheElasticForceIsWithinKOfWhatIsFelt) {
  const double stiffness = 800.0, force = 2.0, k = 0.1;
  SamplePacker packer(deadband(k, 0.05), false, {1e-6, stiffness});
  Vec3 known = Vec3::Zero();
  int count = 0;
  for (std::uint64_t i = 1; i <= 4000; ++i) {
    const double t = kPeriod * static_cast<double>(i);
    Sample s = sample(i, Vec3(0.02 * std::sin(2 * t), 0.01 * std::cos(5 * t), -force / stiffness));
    s.held.elastic = Vec3(0, 0, force);
    if (packer.add(s) != nullptr) {
      known = s.pose.position;
      ++count;
    }
    ASSERT_LE(stiffness * (s.pose.position - known).norm(), k * force * (1 + 1e-9));
  }
  EXPECT_LT(count, 1400);
  EXPECT_GT(count, 100);
}

TEST(PositionDeadband, ForceThatBeginsOrEndsTravelsAtOnce) {
  const auto push = [](std::uint64_t i) {
    Sample s = sample(i);
    if (i >= 8 && i < 13) s.held.elastic = Vec3(0, 0, 1e-9);
    return s;
  };
  const auto all = sent(deadband(0.2, 0.05), {1e-5, 1000.0}, push, 20);
  EXPECT_THAT(all, ElementsAre(1u, 8u, 13u));
}

TEST(PositionDeadband, ALineIsSilentWhileTheHandMovesEvenly) {
  SessionParameters p = deadband(0.1, 0.05);
  p.predictor = Predictor::linear;
  p.local_model = true;
  validate(p);
  const auto turn = [](std::uint64_t i) {  // The rotation is uniform, and reverses at sample 100.
    const double way = static_cast<double>(std::min<std::uint64_t>(i, 100)) -
                       static_cast<double>(std::max<std::uint64_t>(i, 100) - 100);
    return sample(i, Vec3(2e-4 * way, 0, 0));
  };
  const auto all = sent(p, {1e-6, 1000.0}, turn, 150);
  EXPECT_LE(all.size(), 12u);
  EXPECT_GE(all.count(101) + all.count(102), 1u);  // The packer must send the reversal.
  p.predictor = Predictor::level;
  EXPECT_GT(sent(p, {1e-6, 1000.0}, turn, 150).size(), 45u);
}

TEST(PositionDeadband, ATurningToolIsHeardOf) {
  const auto turning = [](std::uint64_t i) {
    Sample s = sample(i);
    s.pose.orientation =
        Quaternion(Eigen::AngleAxisd(5e-4 * static_cast<double>(i), Vec3::UnitY()));
    return s;
  };
  const auto all = sent(deadband(0.1, 0.05), {1e-5, 1000.0}, turning, 301, true);
  EXPECT_GE(all.size(), 75u);  // one sample per 1 mrad, at 0.5 rad/s
  EXPECT_LT(all.size(), 155u);
  EXPECT_LE(sent(deadband(0.1, 0.05), {1e-5, 1000.0}, turning, 301, false).size(), 8u);
}

TEST(PositionDeadband, AClockThatRunsBackHidesNothing) {
  const auto back = [](std::uint64_t i) {
    Sample s = sample(i);
    if (i > 5) s.client_time = Nanoseconds(-1'000'000'000 * static_cast<std::int64_t>(i));
    return s;
  };
  EXPECT_EQ(sent(deadband(0.5, 0.05), {1e-5, 1000.0}, back, 10),
            (std::set<std::uint64_t>{1, 6, 7, 8, 9, 10}));
}

}  // namespace
}  // namespace feltwire::sample_packer_test
