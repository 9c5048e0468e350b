#pragma once
// The bytes of a directory's values: FlatBuffers of fleet.fbs.

#include <optional>
#include <string>
#include <string_view>

#include "server/fleet/scene_record.hpp"
#include "server/fleet/wish.hpp"

namespace feltwire {

/// Longest value that decodes. A directory is written by hosts of the fleet only, but a damaged
/// value must not harm the reader.
inline constexpr std::size_t kMaxRecord = 8192;  // [bytes]

/// The number that a heartbeat has of a scene: hosts with the same number have the same files of
/// it.
std::uint64_t scene_tag(std::string_view name, const SceneDigest& digest);

std::string encode(const SceneRecord& record);
std::string encode(const HostRecord& record);
std::string encode(const Wish& wish);

/// Empty for bytes that are no such record: damaged, too long, without an owner, with a standby
/// that is the owner, or handed over to nobody.
std::optional<SceneRecord> decode_scene_record(std::string_view bytes);
std::optional<HostRecord> decode_host_record(std::string_view bytes);
/// Empty for bytes that are no wish, or a move without a scene, a term or a target.
std::optional<Wish> decode_wish(std::string_view bytes);

}  // namespace feltwire
