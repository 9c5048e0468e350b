// Takes arbitrary bytes as a file of a mesh's convex parts: unchanged, and with a forged head and
// checksum. The result must be a reason for the refusal, or possible parts. Stored again, the parts
// must give equal bytes.

#include <openssl/evp.h>

#include "core/convex/convex_parts_file.hpp"
#include "core/mesh/tessellation.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr std::size_t kMost = 8;
const DecompositionOptions kOptions{.most = kMost};

const TriangleMesh& mesh() {
  static const TriangleMesh made(tessellate(Torus{0.05, 0.015}, 8));
  return made;
}
const PartsKey& key() {
  static const PartsKey made = parts_key(mesh(), kOptions);
  return made;
}

void require_parts(std::string_view bytes) {
  const auto read = read_convex_parts(bytes, key(), mesh(), kOptions);
  if (const auto* why = std::get_if<std::string>(&read)) {
    require(!why->empty(), "a refusal has a reason");
    return;
  }
  const auto& parts = std::get<ConvexParts>(read);
  require(!parts.parts.empty() && parts.parts.size() <= kMost, "there are as many as asked for");
  for (const std::vector<Vec3>& part : parts.parts) {
    require(part.size() >= 4, "a part has corners");
    for (const Vec3& corner : part) require(corner.norm() < 0.1, "corners lie in the mesh's box");
  }
  require(convex_parts_bytes(parts, key()) == bytes,
          "parts are stored as the bytes that they were read from");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string bytes = fuzz::text(data, size);
  fuzz::require_parts(bytes);
  std::string forged = "FWPARTS1" + fuzz::text(fuzz::key().data(), fuzz::key().size()) + bytes;
  PartsKey sum{};
  EVP_Digest(forged.data(), forged.size(), sum.data(), nullptr, EVP_sha256(), nullptr);
  fuzz::require_parts(forged + fuzz::text(sum.data(), sum.size()));
  return 0;
}
