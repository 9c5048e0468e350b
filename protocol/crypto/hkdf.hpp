#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace feltwire {

/// HKDF-Expand with SHA-256 (RFC 5869, 2.3): derives any number of keys from one; `info`
/// separates them. `key` is uniformly random and has 32 bytes or more; `out` has at most 255 * 32.
void hkdf_expand(std::span<const std::uint8_t> key, std::string_view info,
                 std::span<std::uint8_t> out) noexcept;

}  // namespace feltwire
