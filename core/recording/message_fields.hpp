#pragma once
// Fields that several messages have. feltwire's and foxglove's have the same numbers.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/types.hpp"
#include "core/recording/mcap_records.hpp"
#include "core/recording/protobuf.hpp"

namespace feltwire::protobuf {

inline void put_vector(std::string& out, std::uint32_t field, const Vec3& v) {
  put_message(out, field, [&](std::string& to) {
    put(to, 1, v.x());
    put(to, 2, v.y());
    put(to, 3, v.z());
  });
}

inline void put_quaternion(std::string& out, std::uint32_t field, const Quaternion& q) {
  put_message(out, field, [&](std::string& to) {
    put(to, 1, q.x());
    put(to, 2, q.y());
    put(to, 3, q.z());
    put(to, 4, q.w());
  });
}

inline void put_pose(std::string& out, std::uint32_t field, const Pose& pose) {
  put_message(out, field, [&](std::string& to) {
    put_vector(to, 1, pose.position);
    put_quaternion(to, 2, pose.orientation);
  });
}

inline void put_color(std::string& out, std::uint32_t field, double red, double green,
                      double blue) {
  put_message(out, field, [&](std::string& to) {
    put(to, 1, red);
    put(to, 2, green);
    put(to, 3, blue);
    put(to, 4, 1.0);
  });
}

inline void put_time(std::string& out, std::uint32_t field, std::uint64_t time) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  put_message(out, field, [&](std::string& to) {
    put(to, 1, time / kSecond);
    put(to, 2, time % kSecond);
  });
}

/// Appends an entity of a SceneUpdate in this frame. `locked`: the entity moves with the frame;
/// otherwise it stays at its place.
template <class Fill>
void put_entity(std::string& out, std::uint64_t time, std::string_view id, Fill fill,
                std::string_view frame = "world", bool locked = false) {
  put_message(out, 2, [&](std::string& entity) {
    put_time(entity, 1, time);
    put(entity, 2, frame);
    put(entity, 3, id);
    put(entity, 5, std::uint64_t{locked});
    fill(entity);
  });
}

/// Reads numbers of fields 1 to N. False where the bytes are no message.
template <int N>
bool read_numbers(const Field& field, Eigen::Matrix<double, N, 1>& out) {
  out.setZero();  // a zero is not written
  Fields fields(field.bytes);
  while (const auto part = fields.next())
    if (part->is_fixed64 && part->number <= static_cast<std::uint32_t>(N))
      out[static_cast<int>(part->number) - 1] = part->real();
  return field.is_bytes && fields.ok();
}

inline bool read_quaternion(const Field& field, Quaternion& out) {
  return read_numbers<4>(field, out.coeffs());  // x, y, z, w here and there
}

inline bool read_pose(const Field& field, Pose& out) {
  Fields fields(field.bytes);
  bool good = field.is_bytes;
  while (const auto part = fields.next()) {
    if (part->number == 1) good &= read_numbers<3>(*part, out.position);
    if (part->number == 2) good &= read_quaternion(*part, out.orientation);
  }
  return good && fields.ok();
}

/// The schema of a message: its full name, and the FileDescriptorSet that contains it.
template <std::size_t N>
mcap::Schema schema(std::string name, const unsigned char (&descriptors)[N]) {
  return {std::move(name), "protobuf", std::string(reinterpret_cast<const char*>(descriptors), N)};
}

}  // namespace feltwire::protobuf
