#include "server/fleet/record_codec.hpp"

#include <algorithm>
#include <array>

#include "core/base/little_endian.hpp"
#include "protocol/crypto/sha256.hpp"
#include "server/fleet/fleet_generated.h"

namespace feltwire {
namespace {

std::string text_of(const flatbuffers::FlatBufferBuilder& builder) {
  return {reinterpret_cast<const char*>(builder.GetBufferPointer()), builder.GetSize()};
}

flatbuffers::Offset<fleet_file::Host> write_host(flatbuffers::FlatBufferBuilder& builder,
                                                 const HostName& host) {
  return fleet_file::CreateHost(builder, builder.CreateString(host.name), host.number);
}

flatbuffers::Offset<flatbuffers::String> text_or_none(flatbuffers::FlatBufferBuilder& builder,
                                                      const std::string& text) {
  return text.empty() ? flatbuffers::Offset<flatbuffers::String>() : builder.CreateString(text);
}

std::string read_text(const flatbuffers::String* text) {
  return text != nullptr ? text->str() : std::string();
}

HostName read_host(const fleet_file::Host* host) {
  return host != nullptr ? HostName{host->name()->str(), host->number()} : HostName{};
}

template <std::size_t N>
bool read_bytes(const flatbuffers::Vector<std::uint8_t>& from, std::array<std::uint8_t, N>& to) {
  if (from.size() != N) return false;
  std::copy(from.begin(), from.end(), to.begin());
  return true;
}

/// The root of verified bytes; null if they are damaged. FlatBuffers reads numbers at aligned
/// places, so `aligned` takes a copy.
template <class Table>
const Table* verified(std::string_view bytes, std::vector<std::uint64_t>& aligned) {
  if (bytes.size() > kMaxRecord || bytes.size() < sizeof(std::uint64_t)) return nullptr;
  aligned.resize((bytes.size() + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t));
  auto* const start = reinterpret_cast<std::uint8_t*>(aligned.data());
  std::copy(bytes.begin(), bytes.end(), start);
  constexpr int kMostDepth = 4, kMostTables = 64;
  flatbuffers::Verifier verifier(start, bytes.size(), kMostDepth, kMostTables);
  return verifier.VerifyBuffer<Table>(nullptr) ? flatbuffers::GetRoot<Table>(start) : nullptr;
}

}  // namespace

std::uint64_t scene_tag(std::string_view name, const SceneDigest& digest) {
  std::string text(digest.begin(), digest.end());
  text += name;
  return get_little_endian<std::uint64_t>(sha256(text).data());
}

std::string encode(const SceneRecord& record) {
  flatbuffers::FlatBufferBuilder builder;
  const auto owner = write_host(builder, record.owner);
  const auto standby = record.standby.number != 0 ? write_host(builder, record.standby)
                                                  : flatbuffers::Offset<fleet_file::Host>();
  const auto digest = builder.CreateVector(record.digest.data(), record.digest.size());
  builder.Finish(fleet_file::CreateScene(builder, owner, record.version.epoch.term,
                                         record.version.change, standby, digest,
                                         record.handed_over));
  return text_of(builder);
}

std::string encode(const HostRecord& record) {
  flatbuffers::FlatBufferBuilder builder;
  const auto host = write_host(builder, record.host);
  const auto addresses = builder.CreateVectorOfStrings(record.addresses);
  const auto fingerprint =
      builder.CreateVector(record.fingerprint.data(), record.fingerprint.size());
  const auto version = builder.CreateString(record.version);
  const auto rack = builder.CreateString(record.rack);
  std::vector<std::uint8_t> keys;
  for (const paseto::PublicKey& key : record.ticket_keys)
    keys.insert(keys.end(), key.begin(), key.end());
  const auto ticket_keys = builder.CreateVector(keys);
  const auto free_shares = builder.CreateVector(record.free_shares);
  const auto scenes = record.scenes.empty() ? 0 : builder.CreateVector(record.scenes);
  const auto refusal = text_or_none(builder, record.wish_refusal);
  const auto kept = text_or_none(builder, record.kept);
  builder.Finish(fleet_file::CreateHeartbeat(
      builder, host, record.beat, addresses, record.control_port, fingerprint, version, rack,
      ticket_keys, free_shares, record.hands, record.late_p99_us, record.draining, scenes,
      record.wish, refusal, kept));
  return text_of(builder);
}

std::string encode(const Wish& wish) {
  flatbuffers::FlatBufferBuilder builder;
  const auto host = write_host(builder, wish.host);
  const auto scene = text_or_none(builder, wish.scene);
  const auto target = wish.target.number != 0 ? write_host(builder, wish.target)
                                              : flatbuffers::Offset<fleet_file::Host>();
  builder.Finish(fleet_file::CreateWish(
      builder, host, wish.serial, static_cast<std::uint8_t>(wish.kind), scene, wish.term, target));
  return text_of(builder);
}

std::optional<SceneRecord> decode_scene_record(std::string_view bytes) {
  std::vector<std::uint64_t> aligned;
  const auto* const scene = verified<fleet_file::Scene>(bytes, aligned);
  if (scene == nullptr) return std::nullopt;
  SceneRecord record;
  record.owner = read_host(scene->owner());
  record.standby = read_host(scene->standby());
  record.version = {{scene->term(), record.owner.number}, scene->change()};
  record.handed_over = scene->handed_over();
  if (record.owner.number == 0 || record.owner.number == record.standby.number ||
      (record.handed_over && record.standby.number == 0) || record.version.epoch.term == 0 ||
      record.version.change == 0 || !read_bytes(*scene->digest(), record.digest))
    return std::nullopt;
  return record;
}

std::optional<HostRecord> decode_host_record(std::string_view bytes) {
  std::vector<std::uint64_t> aligned;
  const auto* const beat = verified<fleet_file::Heartbeat>(bytes, aligned);
  if (beat == nullptr) return std::nullopt;
  HostRecord record;
  record.host = read_host(beat->host());
  record.beat = beat->beat();
  for (const auto* const address : *beat->addresses()) record.addresses.push_back(address->str());
  record.control_port = beat->control_port();
  record.version = beat->version()->str();
  record.rack = beat->rack()->str();
  constexpr std::size_t kKey = std::tuple_size_v<paseto::PublicKey>;
  const auto& keys = *beat->ticket_keys();
  if (keys.size() % kKey != 0 || keys.size() > kMostTicketKeys * kKey) return std::nullopt;
  for (std::size_t at = 0; at < keys.size(); at += kKey)
    std::copy_n(keys.data() + at, kKey, record.ticket_keys.emplace_back().begin());
  record.free_shares.assign(beat->free_shares()->begin(), beat->free_shares()->end());
  record.hands = beat->hands();
  record.late_p99_us = beat->late_p99_us();
  record.draining = beat->draining();
  if (beat->scenes() != nullptr)
    record.scenes.assign(beat->scenes()->begin(), beat->scenes()->end());
  record.wish = beat->wish();
  record.wish_refusal = read_text(beat->wish_refusal());
  record.kept = read_text(beat->kept());
  if (record.host.number == 0 || !read_bytes(*beat->fingerprint(), record.fingerprint))
    return std::nullopt;
  return record;
}

std::optional<Wish> decode_wish(std::string_view bytes) {
  std::vector<std::uint64_t> aligned;
  const auto* const read = verified<fleet_file::Wish>(bytes, aligned);
  if (read == nullptr || read->kind() > static_cast<std::uint8_t>(WishKind::move))
    return std::nullopt;
  Wish wish;
  wish.host = read_host(read->host());
  wish.serial = read->serial();
  wish.kind = static_cast<WishKind>(read->kind());
  wish.scene = read_text(read->scene());
  wish.term = read->term();
  wish.target = read_host(read->target());
  const bool whole = wish.kind != WishKind::move ||
                     (!wish.scene.empty() && wish.term != 0 && wish.target.number != 0 &&
                      wish.target.number != wish.host.number);
  if (wish.host.number == 0 || wish.serial == 0 || !whole) return std::nullopt;
  return wish;
}

}  // namespace feltwire
