// Tests the bytes of a directory's values.

#include "server/fleet/record_codec.hpp"

#include <gtest/gtest.h>

#include "server/fleet/fleet_generated.h"

namespace feltwire::record_codec_test {
namespace {

SceneRecord scene() {
  SceneRecord record{{"host-a", 11}, {{3, 11}, 7}, {"host-b", 22}, {}, false};
  record.digest.fill(0xab);
  return record;
}

HostRecord heartbeat() {
  HostRecord record;
  record.host = {"host-a", 11};
  record.beat = 123456789012345;
  record.addresses = {"192.0.2.7", "2001:db8::7"};
  record.control_port = 6720;
  record.fingerprint.fill(0x5a);
  record.version = "0.1.0";
  record.rack = "r7";
  record.ticket_keys.resize(2);
  record.ticket_keys[0].fill(1);
  record.ticket_keys[1].fill(2);
  record.free_shares = {100, 37, 0, 54};
  record.hands = 211;
  record.late_p99_us = 480;
  record.draining = true;
  record.wish = 9;
  record.wish_refusal = "host-b drains";
  record.kept = "room: no other host has its files";
  return record;
}

Wish wish() { return {{"host-a", 11}, 4, WishKind::move, "room", 3, {"host-b", 22}}; }

TEST(RecordCodec, BytesGiveTheRecordBack) {
  EXPECT_EQ(decode_scene_record(encode(scene())), scene());
  SceneRecord alone = scene();
  alone.standby = {};
  EXPECT_EQ(decode_scene_record(encode(alone)), alone);
  SceneRecord handed = scene();
  handed.handed_over = true;
  EXPECT_EQ(decode_scene_record(encode(handed)), handed);
  EXPECT_EQ(decode_host_record(encode(heartbeat())), heartbeat());
}

TEST(RecordCodec, AWishIsWholeOrNone) {
  EXPECT_EQ(decode_wish(encode(wish())), wish());
  const Wish drain{{"host-a", 11}, 1, WishKind::drain, {}, 0, {}};
  EXPECT_EQ(decode_wish(encode(drain)), drain);
  const auto refused = [](const auto& spoil) {
    Wish spoilt = wish();
    spoil(spoilt);
    return decode_wish(encode(spoilt)) == std::nullopt;
  };
  EXPECT_FALSE(refused([](Wish&) {}));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.host.number = 0; }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.serial = 0; }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.kind = static_cast<WishKind>(3); }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.scene.clear(); }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.term = 0; }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.target = {}; }));
  EXPECT_TRUE(refused([](Wish& spoilt) { spoilt.target = spoilt.host; }));
}

TEST(RecordCodec, ARecordThatCannotBeIsNone) {
  const auto refused = [](const auto& spoil) {
    SceneRecord record = scene();
    spoil(record);
    return decode_scene_record(encode(record)) == std::nullopt;
  };
  EXPECT_FALSE(refused([](SceneRecord&) {}));
  EXPECT_TRUE(refused([](SceneRecord& record) { record.owner.number = 0; }));
  EXPECT_TRUE(refused([](SceneRecord& record) { record.standby = record.owner; }));
  EXPECT_TRUE(refused([](SceneRecord& record) { record.version.epoch.term = 0; }));
  EXPECT_TRUE(refused([](SceneRecord& record) { record.version.change = 0; }));
  EXPECT_TRUE(refused([](SceneRecord& record) {
    record.handed_over = true;
    record.standby = {};
  }));
  HostRecord nobody = heartbeat();
  nobody.host.number = 0;
  EXPECT_EQ(decode_host_record(encode(nobody)), std::nullopt);
  HostRecord many_keys = heartbeat();
  many_keys.ticket_keys.resize(3);
  EXPECT_EQ(decode_host_record(encode(many_keys)), std::nullopt);

  flatbuffers::FlatBufferBuilder builder;
  const auto host = fleet_file::CreateHostDirect(builder, "a", 1);
  const std::vector<std::uint8_t> short_digest(31);
  builder.Finish(fleet_file::CreateSceneDirect(builder, host, 1, 1, 0, &short_digest));
  EXPECT_EQ(decode_scene_record(
                {reinterpret_cast<const char*>(builder.GetBufferPointer()), builder.GetSize()}),
            std::nullopt);
}

/// Damaged bytes are a value or none, never a fault; the sanitizers look on.
TEST(RecordCodec, DamagedBytesHarmNothing) {
  const std::string scene_bytes = encode(scene()), host_bytes = encode(heartbeat());
  const std::string wish_bytes = encode(wish());
  EXPECT_EQ(decode_scene_record({}), std::nullopt);
  EXPECT_EQ(decode_scene_record(std::string(kMaxRecord + 1, '\0')), std::nullopt);
  for (const std::string& whole : {scene_bytes, host_bytes, wish_bytes}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      decode_scene_record(whole.substr(0, size));
      decode_host_record(whole.substr(0, size));
      decode_wish(whole.substr(0, size));
    }
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const char flip : {'\x01', '\x80', '\xff'}) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ flip);
        if (const auto read = decode_scene_record(damaged)) {
          EXPECT_NE(read->owner.number, 0u);
        }
        decode_host_record(damaged);
        decode_wish(damaged);
      }
    }
  }
  EXPECT_EQ(decode_scene_record(scene_bytes.substr(0, scene_bytes.size() / 2)), std::nullopt);
}

}  // namespace
}  // namespace feltwire::record_codec_test
