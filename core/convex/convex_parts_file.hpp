#pragma once
// Convex parts as bytes in a file, and back. Anyone may have written the file, so all bytes are
// checked.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "core/convex/decomposition.hpp"

namespace feltwire {

/// SHA-256 (FIPS 180-4) of all inputs of the decomposition: the vertices and triangles of the mesh,
/// the options, the versions of the decomposition and of Qhull.
using PartsKey = std::array<std::uint8_t, 32>;
PartsKey parts_key(const TriangleMesh& mesh, const DecompositionOptions& options);

/// "0a1b...", 64 characters.
std::string hex(const PartsKey& key);

/// [bytes] Larger files are not written.
inline constexpr std::size_t kMostConvexPartsFile = std::size_t{1} << 26;

/// The format, little-endian: "FWPARTS1", the key, `outside`, the number of parts, for each part
/// the number of its corners and these, and the SHA-256 of all of it.
std::string convex_parts_bytes(const ConvexParts& parts, const PartsKey& key);

/// Returns the parts, to the bit, or the reason why the bytes are not used: they are damaged,
/// belong to another key, or contain an impossible decomposition of the mesh (more parts than
/// options.most, a corner outside of the mesh's box, a part without volume). It throws only if
/// memory is missing, which the number of bytes limits.
std::variant<ConvexParts, std::string> read_convex_parts(std::string_view bytes,
                                                         const PartsKey& key,
                                                         const TriangleMesh& mesh,
                                                         const DecompositionOptions& options);

}  // namespace feltwire
