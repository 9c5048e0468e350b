#pragma once
// The records of a scene and of a host, as the directory keeps them.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "protocol/crypto/paseto.hpp"
#include "protocol/crypto/tls.hpp"
#include "protocol/fleet/epoch.hpp"

namespace feltwire {

/// SHA-256 of a scene's file and of the files that it names.
using SceneDigest = std::array<std::uint8_t, 32>;

/// A host process as records name it.
struct HostName {
  std::string name;       // for people, and the key of its heartbeat
  HostNumber number = 0;  // of the process; 0: no host

  friend bool operator==(const HostName&, const HostName&) = default;
};

/// Orders all versions of a scene's record without the help of the directory, whose revisions run
/// back when it is restored. Only the holder of an epoch writes records of that epoch.
struct RecordVersion {
  Epoch epoch;
  std::uint64_t change = 0;  // counted by the holder; 0: there is no record

  friend bool operator==(const RecordVersion&, const RecordVersion&) = default;
  friend constexpr bool operator<(const RecordVersion& a, const RecordVersion& b) noexcept {
    return a.epoch == b.epoch ? a.change < b.change : a.epoch < b.epoch;
  }
  friend constexpr bool operator>(const RecordVersion& a, const RecordVersion& b) noexcept {
    return b < a;
  }
  friend constexpr bool operator<=(const RecordVersion& a, const RecordVersion& b) noexcept {
    return !(b < a);
  }
  friend constexpr bool operator>=(const RecordVersion& a, const RecordVersion& b) noexcept {
    return !(a < b);
  }
};

/// The record of a scene.
struct SceneRecord {
  HostName owner;         // its number is the epoch's holder
  RecordVersion version;  // its epoch is the owner's
  HostName standby;       // may take over at reserved_epoch() without a write; number 0: none
  SceneDigest digest{};
  // The owner takes no more joins, and the standby is to serve from now on.
  bool handed_over = false;

  friend bool operator==(const SceneRecord&, const SceneRecord&) = default;
};

/// The epoch that the record reserves for its standby.
constexpr Epoch reserved_epoch(const SceneRecord& record) noexcept {
  return next_epoch(record.version.epoch, record.standby.number);
}

/// Keys of one host whose tickets are valid at a time: the one that signs, and the next or former.
inline constexpr std::size_t kMostTicketKeys = 2;

/// The heartbeat of a host: one write for all of its scenes.
struct HostRecord {
  HostName host;
  std::uint64_t beat = 0;              // counts the heartbeats of this process
  std::vector<std::string> addresses;  // where clients reach it, the best first
  std::uint16_t control_port = 0;
  Fingerprint fingerprint{};  // of its certificate
  std::string version;        // of the program
  std::string rack;           // hosts with the same name here fail together; empty: unknown
  std::vector<paseto::PublicKey> ticket_keys;  // that sign its tickets: one or two
  std::vector<std::uint8_t> free_shares;       // [%] of each pinned core, what scenes do not use
  std::uint32_t hands = 0;
  std::uint32_t late_p99_us = 0;           // [us] the 99th percentile of late answers
  bool draining = false;                   // takes no further scene, and hands its own over
  std::vector<std::uint64_t> scenes = {};  // scene_tag() of each scene that it could serve
  std::uint64_t wish = 0;                  // number of the newest wish that it has read; 0: none
  std::string wish_refusal = {};           // why it does not do that, for people; empty: it does
  std::string kept = {};  // the scenes that it keeps although it drains, and why, for people

  friend bool operator==(const HostRecord&, const HostRecord&) = default;
};

}  // namespace feltwire
