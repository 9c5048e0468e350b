#pragma once
// The messages of a recording, to Protobuf and back, and their schemas.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/types.hpp"
#include "core/recording/mcap_records.hpp"

namespace feltwire {

/// feltwire.Sample (core/recording/feltwire.proto), one a servo tick.
struct RecordedSample {
  double time = 0.0;  // [s] since the first tick
  Pose pose;
  Vec3 elastic = Vec3::Zero(), frictional = Vec3::Zero();  // [N] of the newest command
  Vec3 held = Vec3::Zero();                                // [N] the force on the hand
  Vec3 torque = Vec3::Zero();                              // [N m] with it
  double age = -1.0;                                       // [s] of the command; -1: none yet
};

/// feltwire.Account, one a servo tick.
struct RecordedAccount {
  double time = 0.0;                // [s] since the first tick
  std::optional<double> balance{};  // [J]; empty: there is no account
  double cut = 0.0;                 // share by which the account reduced the command
  std::uint32_t no_force = 0;       // ZeroForceReason (client/servo/zero_force_reason.hpp)
};

void append(std::string& out, const RecordedSample& sample);
void append(std::string& out, const RecordedAccount& account);
/// Empty if the bytes are no such message.
std::optional<RecordedSample> read_sample(std::string_view bytes);
std::optional<RecordedAccount> read_account(std::string_view bytes);

/// foxglove.PoseInFrame: the hand. `time` [ns] since 1970.
void append_pose(std::string& out, std::uint64_t time, const Pose& pose);
inline constexpr double kArrowPerNewton = 0.01;  // [m/N] length of a force's arrow
/// A foxglove.SceneUpdate is the concatenation of these: a hand as a sphere, the force on it [N] as
/// an arrow of 1 cm a newton; a body as a cube, because its shape is not known; and the entities
/// that no longer exist. `id` identifies them.
void append_hand(std::string& out, std::uint64_t time, std::string_view id, const Pose& pose,
                 const Vec3& force);
void append_body(std::string& out, std::uint64_t time, std::string_view id, const Pose& pose);
void append_deletion(std::string& out, std::uint64_t time, std::string_view id);

inline constexpr std::string_view kProtobuf = "protobuf";
mcap::Schema sample_schema();
mcap::Schema account_schema();
mcap::Schema pose_schema();
mcap::Schema picture_schema();

}  // namespace feltwire
