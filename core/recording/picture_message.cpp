#include "core/recording/picture_message.hpp"

#include "core/recording/message_fields.hpp"
#include "core/recording/sample_messages.hpp"

namespace feltwire {
namespace {

using protobuf::Field;
using protobuf::Fields;

/// Reads an arrow as a force. The arrow points along its x axis. Its length is the sum of shaft and
/// head.
bool read_arrow(const Field& field, Vec3& force) {
  Fields fields(field.bytes);
  Pose pose;
  double length = 0.0;
  bool good = field.is_bytes;
  while (const auto part = fields.next()) {
    if (part->number == 1) good &= protobuf::read_pose(*part, pose);
    if (part->is_fixed64 && (part->number == 2 || part->number == 4)) length += part->real();
  }
  force = length / kArrowPerNewton * (pose.orientation * Vec3::UnitX());
  return good && fields.ok();
}

bool read_placed(const Field& field, Pose& pose) {
  Fields fields(field.bytes);
  bool good = field.is_bytes;
  while (const auto part = fields.next())
    if (part->number == 1) good &= protobuf::read_pose(*part, pose);
  return good && fields.ok();
}

bool read_entity(const Field& field, std::vector<PictureEntity>& out) {
  PictureEntity entity;
  Fields fields(field.bytes);
  bool good = field.is_bytes, placed = false;
  while (const auto part = fields.next()) {
    if (part->number == 3) entity.id = part->bytes;
    if (part->number == 7) good &= read_arrow(*part, entity.force);
    if (part->number != 8 && part->number != 9) continue;
    entity.is_hand = part->number == 9;
    good &= read_placed(*part, entity.pose);
    placed = true;
  }
  if (placed) out.push_back(entity);
  return good && fields.ok();
}

}  // namespace

std::optional<std::vector<PictureEntity>> read_picture(std::string_view bytes) {
  std::vector<PictureEntity> entities;
  Fields fields(bytes);
  bool good = true;
  while (const auto field = fields.next())
    if (field->number == 2) good &= read_entity(*field, entities);
  return good && fields.ok() ? std::optional(std::move(entities)) : std::nullopt;
}

}  // namespace feltwire
