#pragma once
// The messages of a live picture that recordings do not have, to Protobuf, and their schemas.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/triangle_soup.hpp"
#include "core/recording/mcap_records.hpp"

namespace feltwire {

/// feltwire.Hand (core/recording/feltwire.proto).
struct LiveHand {
  std::uint32_t number = 0;
  Pose pose;
  Vec3 proxy = Vec3::Zero();                                                    // [m]
  Vec3 elastic = Vec3::Zero(), frictional = Vec3::Zero(), held = Vec3::Zero();  // [N]
  double depth = 0.0;                                                           // [m]
  double delivered = 0.0, burned = 0.0;                                         // [J]
  std::optional<double> balance{};                                              // [J]
  std::optional<double> round_trip{};                                           // [s]
  std::uint64_t samples = 0, missed = 0;
  std::vector<std::string_view> reasons{};
};

/// feltwire.Hands. `time` [s].
void append(std::string& out, double time, std::span<const LiveHand> hands);

/// Appends a foxglove.SceneUpdate with triangles of one colour, in the world frame, or in the named
/// frame and moving with it.
void append_triangles(std::string& out, std::uint64_t time, std::string_view id,
                      const TriangleSoup& soup, const Pose& pose, std::string_view frame = "world");
/// Appends a foxglove.SceneUpdate that deletes everything that was sent on its topic before.
void append_deletion_of_all(std::string& out, std::uint64_t time);
/// Appends a foxglove.FrameTransforms with the pose of a frame in the world.
void append_transform(std::string& out, std::uint64_t time, std::string_view frame,
                      const Pose& pose);

mcap::Schema hands_schema();
mcap::Schema transforms_schema();

}  // namespace feltwire
