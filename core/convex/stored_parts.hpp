#pragma once
// Convex parts as bytes that can be kept, and back. The bytes come from a file that anybody may
// have written, so all of them are checked.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "core/convex/decomposition.hpp"

namespace feltwire {

/// SHA-256 (FIPS 180-4) of all that decides the parts of a mesh: its vertices and triangles, the
/// options, the versions of the decomposition and of Qhull.
using PartsKey = std::array<std::uint8_t, 32>;
PartsKey parts_key(const TriangleMesh& mesh, const DecompositionOptions& options);

/// "0a1b...", 64 characters.
std::string hex(const PartsKey& key);

/// [bytes] Nothing larger is kept.
inline constexpr std::size_t kMostStoredParts = std::size_t{1} << 26;

/// Little-endian: "FWPARTS1", the key, `outside`, the number of parts, of each part the number of
/// its corners and these, and the SHA-256 of all of it.
std::string store(const ConvexParts& parts, const PartsKey& key);

/// The parts, to the bit, or the reason why the bytes are not used: they are damaged, belong to
/// another key, or hold what no decomposition of the mesh gives (a number of parts beyond
/// options.most, a corner outside of the mesh's box, a part that has no volume). Never throws but
/// for a lack of memory, which the number of bytes bounds.
std::variant<ConvexParts, std::string> stored_parts(std::string_view bytes, const PartsKey& key,
                                                    const TriangleMesh& mesh,
                                                    const DecompositionOptions& options);

}  // namespace feltwire
