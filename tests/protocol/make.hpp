#pragma once
// Datagrams for tests.

#include <random>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"

namespace feltwire::test {

using Generator = std::mt19937_64;

inline double uniform(Generator& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline Vec3 vector(Generator& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
/// Numbers that float32 on the wire keeps exactly.
inline Vec3 float_vector(Generator& random, double size) {
  // Draw floats: GCC 12 at -O3 loses the rounding of double -> float -> double on a vector lane.
  std::uniform_real_distribution<float> number(static_cast<float>(-size), static_cast<float>(size));
  const float x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

/// A batch of `count` random samples; the newest has the index `newest`.
inline SampleBatch random_batch(Generator& random, std::uint64_t newest, int count, bool rotation) {
  SampleBatch batch;
  batch.count = count;
  batch.rotation = rotation;
  for (int i = 0; i < count; ++i) {
    Sample& s = batch.samples[static_cast<std::size_t>(i)];
    s.index = newest - static_cast<std::uint64_t>(i);
    s.client_time = Nanoseconds(static_cast<std::int64_t>(random() >> 2));
    s.pose.position = vector(random, 0.5);
    s.held = {float_vector(random, 10), float_vector(random, 3), Vec3::Zero()};
    if (rotation) {
      s.pose.orientation = Quaternion(uniform(random, -1, 1), uniform(random, -1, 1),
                                      uniform(random, -1, 1), uniform(random, 0.1, 1))
                               .normalized();
      s.held.torque = float_vector(random, 0.5);
    }
  }
  return batch;
}

inline constexpr unsigned kAllKinds = 0b111110;

}  // namespace feltwire::test
