#include "core/recording/live_messages.hpp"

#include "core/recording/feltwire_descriptors.hpp"
#include "core/recording/foxglove_descriptors.hpp"
#include "core/recording/mcap_bytes.hpp"
#include "core/recording/message_fields.hpp"

namespace feltwire {
namespace {

using protobuf::put;
using protobuf::put_message;

void put_hand(std::string& out, const LiveHand& hand) {
  using protobuf::put_vector;
  put(out, 1, std::uint64_t{hand.number});
  put_vector(out, 2, hand.pose.position);
  protobuf::put_quaternion(out, 3, hand.pose.orientation);
  put_vector(out, 4, hand.proxy);
  put_vector(out, 5, hand.elastic);
  put_vector(out, 6, hand.frictional);
  put_vector(out, 7, hand.held);
  put(out, 8, hand.depth);
  put(out, 9, hand.delivered);
  put(out, 10, hand.burned);
  if (hand.balance) protobuf::put_optional(out, 11, *hand.balance);
  if (hand.round_trip) protobuf::put_optional(out, 12, *hand.round_trip);
  put(out, 13, hand.samples);
  put(out, 14, hand.missed);
  for (const std::string_view reason : hand.reasons) put(out, 15, reason);
}

}  // namespace

void append(std::string& out, double time, std::span<const LiveHand> hands) {
  put(out, 1, time);
  for (const LiveHand& hand : hands)
    put_message(out, 2, [&](std::string& to) { put_hand(to, hand); });
}

void append_triangles(std::string& out, std::uint64_t time, std::string_view id,
                      const TriangleSoup& soup, const Pose& pose, std::string_view frame) {
  protobuf::put_entity(
      out, time, id,
      [&](std::string& entity) {
        put_message(entity, 12, [&](std::string& list) {
          protobuf::put_pose(list, 1, pose);
          for (const Vec3& vertex : soup.vertices) protobuf::put_vector(list, 2, vertex);
          protobuf::put_color(list, 3, 0.6, 0.6, 0.65);
          std::string corners;  // packed list of fixed32 numbers
          corners.reserve(soup.triangles.size() * 3 * sizeof(std::uint32_t));
          for (const Triangle& triangle : soup.triangles)
            for (const std::uint32_t corner : triangle) mcap::put(corners, corner);
          put(list, 5, corners);
        });
      },
      frame, frame != "world");
}

void append_deletion_of_all(std::string& out, std::uint64_t time) {
  constexpr std::uint64_t kAll = 1;
  put_message(out, 1, [&](std::string& deletion) {
    protobuf::put_time(deletion, 1, time);
    put(deletion, 2, kAll);
  });
}

void append_transform(std::string& out, std::uint64_t time, std::string_view frame,
                      const Pose& pose) {
  put_message(out, 1, [&](std::string& transform) {
    protobuf::put_time(transform, 1, time);
    put(transform, 2, "world");
    put(transform, 3, frame);
    protobuf::put_vector(transform, 4, pose.position);
    protobuf::put_quaternion(transform, 5, pose.orientation);
  });
}

mcap::Schema hands_schema() {
  return protobuf::schema("feltwire.Hands", embedded::feltwire_descriptors);
}
mcap::Schema transforms_schema() {
  return protobuf::schema("foxglove.FrameTransforms", embedded::foxglove_descriptors);
}

}  // namespace feltwire
