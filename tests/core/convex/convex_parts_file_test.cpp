// Tests convex parts as bytes. Reading must restore the parts bitwise, and must refuse other bytes.

#include "core/convex/convex_parts_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <cmath>
#include <cstring>

#include "tests/support/meshes.hpp"

namespace feltwire::convex_parts_file_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kKeyAt = 8, kOutsideAt = 40, kCountAt = 48, kFirstPartAt = 52, kDigest = 32;

/// The parts of a ring and their bytes.
class StoredParts : public ::testing::Test {
 protected:
  /// Returns "taken", or the reason for the refusal.
  std::string answer(std::string_view given, const DecompositionOptions& with = {}) const {
    const auto read = read_convex_parts(given, key, ring.mesh(), with);
    const auto* why = std::get_if<std::string>(&read);
    return why == nullptr ? "taken" : *why;
  }
  /// Returns the answer to a forged file with a valid checksum.
  std::string forged(std::size_t at, std::string_view put) const {
    std::string changed = bytes.substr(0, bytes.size() - kDigest);
    changed.replace(at, put.size(), put);
    return answer(summed(changed));
  }
  static std::string summed(std::string text) {
    std::array<unsigned char, kDigest> sum{};
    EVP_Digest(text.data(), text.size(), sum.data(), nullptr, EVP_sha256(), nullptr);
    return text.append(reinterpret_cast<const char*>(sum.data()), sum.size());
  }

  template <class Number>
  static std::string little_endian(Number number) {
    std::string text(sizeof number, '\0');
    std::memcpy(text.data(), &number, sizeof number);
    return text;
  }

  const MeshSurface ring{TriangleMesh(test::torus(0.05, 0.015, 12, 6))};
  const PartsKey key = parts_key(ring.mesh(), {});
  const ConvexParts parts = convex_parts(ring, {});
  const std::string bytes = convex_parts_bytes(parts, key);
};

TEST_F(StoredParts, ComeBackToTheBit) {
  const auto read = read_convex_parts(bytes, key, ring.mesh(), {});
  const auto* back = std::get_if<ConvexParts>(&read);
  ASSERT_NE(back, nullptr) << std::get<std::string>(read);
  EXPECT_EQ(back->parts, parts.parts);
  EXPECT_EQ(back->outside, parts.outside);
  EXPECT_EQ(back->tolerance, parts.tolerance);
  EXPECT_EQ(convex_parts_bytes(*back, key), bytes);
}

TEST_F(StoredParts, NoByteMayBeChangedLeftOutOrAdded) {
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    ASSERT_NE(answer(flipped), "taken") << at;
    ASSERT_NE(answer(std::string_view(bytes).substr(0, at)), "taken") << at;
  }
  EXPECT_NE(answer(bytes + '\0'), "taken");
  EXPECT_EQ(answer(bytes), "taken");
}

TEST_F(StoredParts, OfAnotherMeshOrOtherOptionsAreNotTaken) {
  const std::string another = "is of another mesh, of other options or of another version";
  const MeshSurface larger(TriangleMesh(test::torus(0.05, 0.015 * (1 + 1e-15), 12, 6)));
  // The default tolerance depends on the mesh. Both meshes use one tolerance here.
  const DecompositionOptions same{.tolerance = 0.003};
  EXPECT_NE(parts_key(larger.mesh(), same), parts_key(ring.mesh(), same));
  for (const DecompositionOptions& options :
       {DecompositionOptions{.tolerance = 0.003}, DecompositionOptions{.most = 63}})
    EXPECT_NE(parts_key(ring.mesh(), options), key);
  // The explicit default tolerance must give the same key.
  EXPECT_EQ(parts_key(ring.mesh(), {.tolerance = kPartTolerance * ring.mesh().report().size}), key);
  EXPECT_EQ(answer(convex_parts_bytes(parts, parts_key(larger.mesh(), {}))), another);
  EXPECT_EQ(answer(convex_parts_bytes(parts, parts_key(ring.mesh(), {.most = 63}))), another);
}

TEST_F(StoredParts, AForgersCountsAndNumbersAreBounded) {
  EXPECT_EQ(forged(kKeyAt, bytes.substr(kKeyAt, 1)), "taken");  // The forger's checksum is valid.
  for (const std::uint32_t count : {0u, 65u, 0xFFFFFFFFu})
    EXPECT_THAT(forged(kCountAt, little_endian(count)), HasSubstr("parts where 1 to 64"));
  const auto count = static_cast<std::uint32_t>(parts.parts.size());
  EXPECT_THAT(forged(kCountAt, little_endian(count + 1)), HasSubstr("ends before its last part"));
  EXPECT_THAT(forged(kCountAt, little_endian(count - 1)), HasSubstr("goes on behind"));
  for (const std::uint32_t corners : {0u, 3u, 0xFFFFFFFFu, 0x10000000u})
    EXPECT_THAT(forged(kFirstPartAt, little_endian(corners)), HasSubstr("more corners than"));
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double outside : {-1.0, 1.0, infinity, std::nan("")})
    EXPECT_THAT(forged(kOutsideAt, little_endian(outside)), HasSubstr("by more than its size"));
  for (const double x : {0.0651, -0.0651, infinity, std::nan("")})
    EXPECT_THAT(forged(kFirstPartAt + 4, little_endian(x)), HasSubstr("outside of the mesh"));
  // All corners of the first part are at one point.
  std::string flat;
  for (std::size_t i = 0; i < parts.parts[0].size(); ++i)
    for (int axis = 0; axis < 3; ++axis) flat += little_endian(0.01);
  EXPECT_THAT(forged(kFirstPartAt + 4, flat), HasSubstr("without a volume"));
}

}  // namespace
}  // namespace feltwire::convex_parts_file_test
