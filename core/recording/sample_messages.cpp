#include "core/recording/sample_messages.hpp"

#include "core/recording/feltwire_descriptors.hpp"
#include "core/recording/foxglove_descriptors.hpp"
#include "core/recording/message_fields.hpp"

namespace feltwire {
namespace {

using protobuf::Field;
using protobuf::Fields;
using protobuf::put;
using protobuf::put_color;
using protobuf::put_entity;
using protobuf::put_message;
using protobuf::put_pose;
using protobuf::put_quaternion;
using protobuf::put_time;
using protobuf::put_vector;
using protobuf::read_numbers;
using protobuf::read_quaternion;
using protobuf::schema;

}  // namespace

void append(std::string& out, const RecordedSample& sample) {
  put(out, 1, sample.time);
  put_vector(out, 2, sample.pose.position);
  put_quaternion(out, 3, sample.pose.orientation);
  put_vector(out, 4, sample.elastic);
  put_vector(out, 5, sample.frictional);
  put_vector(out, 6, sample.held);
  put_vector(out, 7, sample.torque);
  put(out, 8, sample.age);
}

void append(std::string& out, const RecordedAccount& account) {
  put(out, 1, account.time);
  if (account.balance) protobuf::put_optional(out, 2, *account.balance);
  put(out, 3, account.cut);
  put(out, 4, std::uint64_t{account.no_force});
}

std::optional<RecordedSample> read_sample(std::string_view bytes) {
  RecordedSample sample;
  sample.age = 0.0;
  bool good = true;
  Fields fields(bytes);
  while (const auto field = fields.next()) {
    switch (field->number) {
      case 1:
        sample.time = field->real();
        break;
      case 2:
        good &= read_numbers<3>(*field, sample.pose.position);
        break;
      case 3:
        good &= read_quaternion(*field, sample.pose.orientation);
        break;
      case 4:
        good &= read_numbers<3>(*field, sample.elastic);
        break;
      case 5:
        good &= read_numbers<3>(*field, sample.frictional);
        break;
      case 6:
        good &= read_numbers<3>(*field, sample.held);
        break;
      case 7:
        good &= read_numbers<3>(*field, sample.torque);
        break;
      case 8:
        sample.age = field->real();
        break;
      default:  // Skip a field from a newer version.
        break;
    }
  }
  return good && fields.ok() ? std::optional(sample) : std::nullopt;
}

std::optional<RecordedAccount> read_account(std::string_view bytes) {
  RecordedAccount account;
  Fields fields(bytes);
  while (const auto field = fields.next()) {
    switch (field->number) {
      case 1:
        account.time = field->real();
        break;
      case 2:
        account.balance = field->real();
        break;
      case 3:
        account.cut = field->real();
        break;
      case 4:
        account.no_force = static_cast<std::uint32_t>(field->value);
        break;
      default:
        break;
    }
  }
  return fields.ok() ? std::optional(account) : std::nullopt;
}

void append_pose(std::string& out, std::uint64_t time, const Pose& pose) {
  put_time(out, 1, time);
  put(out, 2, "world");
  put_pose(out, 3, pose);
}

void append_hand(std::string& out, std::uint64_t time, std::string_view id, const Pose& pose,
                 const Vec3& force) {
  // [m] diameter of the sphere; thickness of the arrow.
  constexpr double kHand = 0.008, kThick = 0.003;
  constexpr double kHead = 0.3;
  put_entity(out, time, id, [&](std::string& entity) {
    const double length = kArrowPerNewton * force.norm();
    if (length > 0.0)
      put_message(entity, 7, [&](std::string& arrow) {
        put_pose(arrow, 1, {pose.position, turn_to(Vec3::UnitX(), force)});
        put(arrow, 2, (1.0 - kHead) * length);
        put(arrow, 3, kThick);
        put(arrow, 4, kHead * length);
        put(arrow, 5, 2.0 * kThick);
        put_color(arrow, 6, 0.9, 0.3, 0.1);
      });
    put_message(entity, 9, [&](std::string& sphere) {
      put_pose(sphere, 1, pose);
      put_vector(sphere, 2, Vec3::Constant(kHand));
      put_color(sphere, 3, 0.2, 0.5, 0.9);
    });
  });
}

void append_body(std::string& out, std::uint64_t time, std::string_view id, const Pose& pose) {
  constexpr double kBody = 0.02;  // [m] side length of the cube
  put_entity(out, time, id, [&](std::string& entity) {
    put_message(entity, 8, [&](std::string& cube) {
      put_pose(cube, 1, pose);
      put_vector(cube, 2, Vec3::Constant(kBody));
      put_color(cube, 3, 0.6, 0.6, 0.6);
    });
  });
}

void append_deletion(std::string& out, std::uint64_t time, std::string_view id) {
  put_message(out, 1, [&](std::string& deletion) {
    put_time(deletion, 1, time);
    put(deletion, 3, id);
  });
}

mcap::Schema sample_schema() { return schema("feltwire.Sample", embedded::feltwire_descriptors); }
mcap::Schema account_schema() { return schema("feltwire.Account", embedded::feltwire_descriptors); }
mcap::Schema pose_schema() {
  return schema("foxglove.PoseInFrame", embedded::foxglove_descriptors);
}
mcap::Schema picture_schema() {
  return schema("foxglove.SceneUpdate", embedded::foxglove_descriptors);
}

}  // namespace feltwire
