// Tests an observer's view as bytes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "flatbuffers/flatbuffers.h"
#include "protocol/session/profiles.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/datagram_generated.h"
#include "protocol/wire/scene_view.hpp"
#include "tests/protocol/make.hpp"
#include "tests/protocol/misaligned.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::view_codec_test {
namespace {

using test::float_vector;
using test::Generator;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

Pose random_pose(Generator& random) {
  Pose pose;
  pose.position = float_vector(random, 1);
  pose.orientation = Quaternion(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                                test::uniform(random, -1, 1), test::uniform(random, 0.1, 1))
                         .normalized();
  return pose;
}

SceneView view_of(std::size_t hands, std::size_t bodies, Generator& random) {
  SceneView view;
  view.hands_from = 3;
  view.hands_end = SceneView::kLastHand;
  view.bodies_from = 1;
  view.bodies_end = 100;
  view.hand_count = hands;
  view.body_count = bodies;
  for (std::size_t i = 0; i < hands; ++i)
    view.hand[i] = {static_cast<std::uint32_t>(4 + 2 * i), random_pose(random),
                    float_vector(random, 10)};
  for (std::size_t i = 0; i < bodies; ++i)
    view.body[i] = {static_cast<std::uint16_t>(1 + 3 * i), random_pose(random)};
  return view;
}

/// Returns a reply with all possible contents except a model.
Reply longest_reply() {
  Reply reply;
  reply.sample_index = reply.withheld = ~std::uint64_t{0};
  reply.client_time = reply.server_times.received = reply.server_times.sent = Nanoseconds(-1);
  reply.rotation = reply.predicted = true;
  return reply;
}

void expect_near(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_LE((a.orientation.coeffs() - b.orientation.coeffs()).norm(), 1e-6);
}

TEST(ViewCodec, RoundTrip) {
  Generator random(31);
  Encoder encoder;
  for (int round = 0; round < 200; ++round) {
    const SceneView sent = view_of(random() % 16, random() % 4, random);
    Reply reply;
    SceneView got;
    ASSERT_EQ(decode(encoder.reply(longest_reply(), &sent), reply, &got), DropReason::none);
    ASSERT_TRUE(got.present);
    EXPECT_EQ(got.hands_from, sent.hands_from);
    EXPECT_EQ(got.hands_end, sent.hands_end);
    EXPECT_EQ(got.bodies_from, sent.bodies_from);
    EXPECT_EQ(got.bodies_end, sent.bodies_end);
    ASSERT_EQ(got.hand_count, sent.hand_count);
    ASSERT_EQ(got.body_count, sent.body_count);
    for (std::size_t i = 0; i < sent.hand_count; ++i) {
      EXPECT_EQ(got.hand[i].number, sent.hand[i].number);
      EXPECT_EQ(got.hand[i].force, sent.hand[i].force);
      expect_near(got.hand[i].pose, sent.hand[i].pose);
    }
    for (std::size_t i = 0; i < sent.body_count; ++i) {
      EXPECT_EQ(got.body[i].object, sent.body[i].object);
      expect_near(got.body[i].pose, sent.body[i].pose);
    }
    EXPECT_EQ(decode(encoder.reply(longest_reply(), &sent), reply), DropReason::none);
  }
}

HandFigures figures_of(Generator& random) {
  HandFigures f;
  f.samples = ~std::uint64_t{0};
  f.missed = 7;
  f.proxy = float_vector(random, 1);
  f.elastic = float_vector(random, 10);
  f.frictional = float_vector(random, 10);
  f.depth = 0.25;
  f.delivered = -0.5;
  f.burned = 2.0;
  f.states = 0x80000003u;
  f.tool = 65535;
  return f;
}

SceneView view_with_figures(std::size_t hands, std::size_t bodies, Generator& random) {
  SceneView view = view_of(hands, bodies, random);
  for (std::size_t i = 0; i < hands; ++i) view.hand[i].figures = figures_of(random);
  return view;
}

TEST(ViewCodec, FiguresOfHandsRoundTrip) {
  Generator random(36);
  Encoder encoder;
  Reply reply;
  SceneView got;
  for (std::size_t hands = 0; hands <= SceneView::kMaxFigures; ++hands) {
    SceneView sent = view_with_figures(hands, 2, random);
    if (hands > 1)
      sent.hand[1].figures->report = HandReport{
          .reasons = 5, .has_account = true, .balance = 0.125, .round_trip = 0.5, .late_ticks = 77};
    ASSERT_EQ(decode(encoder.reply(longest_reply(), &sent), reply, &got), DropReason::none);
    ASSERT_EQ(got.hand_count, hands);
    for (std::size_t i = 0; i < hands; ++i) {
      const HandFigures &a = *sent.hand[i].figures, &b = got.hand[i].figures.value();
      EXPECT_EQ(b.samples, a.samples);
      EXPECT_EQ(b.missed, a.missed);
      EXPECT_EQ(b.proxy, a.proxy);
      EXPECT_EQ(b.elastic, a.elastic);
      EXPECT_EQ(b.frictional, a.frictional);
      EXPECT_EQ(b.depth, a.depth);
      EXPECT_EQ(b.delivered, a.delivered);
      EXPECT_EQ(b.burned, a.burned);
      EXPECT_EQ(b.states, a.states);
      EXPECT_EQ(b.tool, a.tool);
      ASSERT_EQ(b.report.has_value(), a.report.has_value());
      if (!a.report) continue;
      EXPECT_EQ(b.report->reasons, a.report->reasons);
      EXPECT_TRUE(b.report->has_account);
      EXPECT_EQ(b.report->balance, a.report->balance);
      EXPECT_EQ(b.report->round_trip, a.report->round_trip);
      EXPECT_EQ(b.report->late_ticks, 77u);
    }
  }
  // The next view has no figures. Figures of the last view must not remain.
  const SceneView plain = view_of(3, 0, random);
  ASSERT_EQ(decode(encoder.reply(longest_reply(), &plain), reply, &got), DropReason::none);
  for (const SeenHand& hand : got.hands()) EXPECT_FALSE(hand.figures.has_value());
}

TEST(ViewCodec, FiguresFitTheRoomOfAView) {
  Generator random(37);
  Encoder encoder;
  Reply modelled = longest_reply();
  modelled.modelled = true;
  modelled.model.count = kMaxPatches;
  constexpr std::size_t kSize = SceneView::kHandSize + SceneView::kFiguresSize;
  for (const double between : {0.001, 0.08}) {
    const std::size_t room = view_room(between) - kFiguresOverhead;
    EXPECT_LE(room / kSize, SceneView::kMaxFigures);
    for (std::size_t hands = 0; hands <= room / kSize; ++hands) {
      const SceneView view =
          view_with_figures(hands, (room - hands * kSize) / SceneView::kBodySize, random);
      EXPECT_LE(encoder.reply(longest_reply(), &view).size(),
                between < 0.04 ? kMaxPayload : encoder.reply(modelled).size())
          << between << " s, " << hands << " hands";
    }
  }
}

TEST(ViewCodec, FiguresThatAreNoneAreDropped) {
  const std::vector<std::function<void(HandFigures&)>> spoils = {
      [](HandFigures& f) { f.proxy.x() = kNotANumber; },
      [](HandFigures& f) { f.elastic.y() = kInfinity; },
      [](HandFigures& f) { f.frictional.z() = kNotANumber; },
      [](HandFigures& f) { f.depth = kNotANumber; },
      [](HandFigures& f) { f.delivered = kInfinity; },
      [](HandFigures& f) { f.burned = kNotANumber; },
      [](HandFigures& f) { f.report = HandReport{.balance = kNotANumber}; },
      [](HandFigures& f) { f.report = HandReport{.round_trip = kInfinity}; },
  };
  Generator random(38);
  Encoder encoder;
  Reply reply;
  SceneView got;
  for (std::size_t which = 0; which < spoils.size(); ++which) {
    SceneView view = view_with_figures(2, 1, random);
    spoils[which](*view.hand[1].figures);
    const Bytes bytes = encoder.reply(longest_reply(), &view);
    EXPECT_EQ(decode(bytes, reply, &got), DropReason::not_finite) << "spoil " << which;
    EXPECT_EQ(decode(bytes, reply), DropReason::not_finite) << "unread, spoil " << which;
  }
}

/// FlatBuffers' verifier accepts misaligned numbers, but reading them is undefined.
TEST(ViewCodec, FiguresOutOfPlaceAreDropped) {
  Generator random(39);
  Encoder encoder;
  const SceneView view = view_with_figures(2, 1, random);
  const Bytes sent = encoder.reply(longest_reply(), &view);
  const std::vector<std::uint8_t> bytes(sent.begin(), sent.end());
  const auto* seen = flatbuffers::GetRoot<wire::Reply>(bytes.data())->view();
  const auto moved = test::with_misaligned_vector(
      bytes, bytes.data(), seen, wire::SceneView::VT_FIGURES, 2 * sizeof(wire::HandFigures));
  flatbuffers::Verifier verifier(moved.data(), moved.size());
  ASSERT_TRUE(verifier.VerifyBuffer<wire::Reply>(nullptr));
  Reply reply;
  SceneView got;
  EXPECT_EQ(decode(moved, reply, &got), DropReason::malformed);
  EXPECT_EQ(decode(moved, reply), DropReason::malformed);
}

/// Without an observer, a reply must have the bytes of versions without views.
TEST(ViewCodec, WhoIsShownNothingPaysNoByte) {
  Encoder encoder;
  Reply reply = longest_reply();
  EXPECT_EQ(encoder.reply(reply).size(), 224u);
  reply.rotation = reply.predicted = false;
  EXPECT_EQ(encoder.reply(reply).size(), 160u);
  reply.withheld = 0;
  EXPECT_EQ(encoder.reply(reply).size(), 152u);
  reply.modelled = true;
  reply.model.count = kMaxPatches;
  EXPECT_EQ(encoder.reply(reply).size(), 504u);
  SceneView view;
  view.present = true;
  EXPECT_EQ(decode(encoder.reply(reply), reply, &view), DropReason::none);
  EXPECT_FALSE(view.present);
}

/// PROTOCOL.md states these sizes.
TEST(ViewCodec, IsAsLongAsItSays) {
  Generator random(32);
  Encoder encoder;
  const Reply reply = longest_reply();
  const auto size = [&](std::size_t hands, std::size_t bodies) {
    const SceneView view = view_of(hands, bodies, random);
    return encoder.reply(reply, &view).size();
  };
  EXPECT_EQ(size(0, 0) + kOverhead, 304u);
  EXPECT_EQ(size(1, 0) + kOverhead, 360u);
  EXPECT_EQ(size(2, 1) + kOverhead, 440u);
  EXPECT_EQ(size(19, 1) + kOverhead, 1192u);
  EXPECT_EQ(size(6, 0) + kOverhead, 576u);
  for (const double between : {0.001, 0.08}) {
    const std::size_t room = view_room(between);
    std::size_t longest = 0;
    for (std::size_t hands = 0; hands <= room / SceneView::kHandSize; ++hands)
      longest = std::max(longest,
                         size(hands, (room - hands * SceneView::kHandSize) / SceneView::kBodySize));
    Reply modelled = reply;
    modelled.modelled = true;
    modelled.model.count = kMaxPatches;
    EXPECT_LE(longest, between < 0.04 ? kMaxPayload : encoder.reply(modelled).size()) << between;
  }
  EXPECT_EQ(view_room(0.001) / SceneView::kHandSize, SceneView::kMaxHands);
  EXPECT_EQ(view_room(0.001) / SceneView::kBodySize, SceneView::kMaxBodies);
  const NetworkProfile& thin = network_profile("thin");
  EXPECT_EQ(view_room(1.0 / thin.packet_rate), view_room(1.0));
}

TEST(ViewCodec, TakesNoMemoryAfterTheFirst) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers count by themselves";
#endif
  Generator random(33);
  const SceneView view = view_of(SceneView::kMaxHands, 0, random);
  Reply reply;
  SceneView got;
  Encoder encoder;
  encoder.reply({}, nullptr);
  const std::size_t before = test::allocations();
  EXPECT_EQ(decode(encoder.reply(longest_reply(), &view), reply, &got), DropReason::none);
  EXPECT_EQ(decode(encoder.reply(longest_reply(), &view), reply), DropReason::none);
  EXPECT_EQ(test::allocations(), before);
}

TEST(ViewCodec, WhatIsNoViewIsDropped) {
  struct Spoil {
    DropReason drop;
    std::function<void(SceneView&)> apply;
  };
  const std::vector<Spoil> spoils = {
      {DropReason::order, [](SceneView& v) { v.hands_from = 5; }},
      {DropReason::order, [](SceneView& v) { v.hands_end = 6; }},
      {DropReason::order, [](SceneView& v) { v.hand[1].number = v.hand[0].number; }},
      {DropReason::order, [](SceneView& v) { v.bodies_from = 2; }},
      {DropReason::order, [](SceneView& v) { v.bodies_end = 4; }},
      {DropReason::order, [](SceneView& v) { std::swap(v.body[0], v.body[1]); }},
      {DropReason::not_finite, [](SceneView& v) { v.hand[1].pose.position.x() = kNotANumber; }},
      {DropReason::not_finite, [](SceneView& v) { v.hand[1].force.y() = kInfinity; }},
      {DropReason::not_finite, [](SceneView& v) { v.hand[0].pose.orientation.w() = kNotANumber; }},
      {DropReason::not_finite, [](SceneView& v) { v.body[1].pose.position.z() = kInfinity; }},
      {DropReason::not_finite, [](SceneView& v) { v.body[0].pose.orientation.coeffs() *= 1.01; }},
      // With two faults, the result of the first check must count.
      {DropReason::order,
       [](SceneView& v) { v.hand[0].force.x() = kNotANumber, v.body[1].object = 0; }},
  };
  Generator random(34);
  Encoder encoder;
  Reply reply;
  SceneView got;
  for (std::size_t which = 0; which < spoils.size(); ++which) {
    SceneView view = view_of(2, 2, random);
    ASSERT_EQ(decode(encoder.reply(longest_reply(), &view), reply, &got), DropReason::none);
    spoils[which].apply(view);
    const Bytes bytes = encoder.reply(longest_reply(), &view);
    EXPECT_EQ(decode(bytes, reply, &got), spoils[which].drop) << "spoil " << which;
    EXPECT_EQ(decode(bytes, reply), spoils[which].drop) << "unread, spoil " << which;
  }
}

std::vector<wire::SeenHand> hands_at_rest(std::size_t count) {
  std::vector<wire::SeenHand> hands;
  const wire::Vec3f zero(0, 0, 0);
  for (std::size_t i = 0; i < count; ++i)
    hands.emplace_back(zero, wire::Quatf(1, 0, 0, 0), zero, static_cast<std::uint32_t>(i));
  return hands;
}

/// Returns the verdict on a reply that contains `view`.
DropReason verdict_on(flatbuffers::FlatBufferBuilder& builder,
                      flatbuffers::Offset<wire::SceneView> view) {
  const wire::Vec3d zero;
  const wire::BoundingReport report;
  builder.Finish(
      wire::CreateReply(builder, 1, 0, 0, 0, &zero, &zero, nullptr, &report, 0, nullptr, 0, view));
  Reply reply;
  SceneView got;
  return decode(Bytes(builder.GetBufferPointer(), builder.GetSize()), reply, &got);
}

TEST(ViewCodec, AsManyFiguresAsHands) {
  const auto verdict = [](std::size_t hands, std::size_t figures) {
    flatbuffers::FlatBufferBuilder builder;
    return verdict_on(
        builder, wire::CreateSceneView(
                     builder, 0, 99, 0, 99, builder.CreateVectorOfStructs(hands_at_rest(hands)), 0,
                     builder.CreateVectorOfStructs(std::vector<wire::HandFigures>(figures))));
  };
  EXPECT_EQ(verdict(6, 6), DropReason::none);
  EXPECT_EQ(verdict(0, 0), DropReason::none);
  EXPECT_EQ(verdict(2, 1), DropReason::count);
  EXPECT_EQ(verdict(1, 2), DropReason::count);
  EXPECT_EQ(verdict(7, 7), DropReason::count);
  EXPECT_EQ(verdict(SceneView::kMaxHands + 1, 1), DropReason::count);
}

TEST(ViewCodec, MoreThanAViewMayHave) {
  const auto verdict = [](std::size_t hands, std::size_t bodies) {
    flatbuffers::FlatBufferBuilder builder;
    std::vector<wire::SeenBody> many_bodies;
    for (std::size_t i = 0; i < bodies; ++i)
      many_bodies.emplace_back(wire::Vec3f(0, 0, 0), wire::Quatf(1, 0, 0, 0),
                               static_cast<std::uint16_t>(i));
    return verdict_on(builder,
                      wire::CreateSceneView(builder, 0, 99, 0, 99,
                                            builder.CreateVectorOfStructs(hands_at_rest(hands)),
                                            builder.CreateVectorOfStructs(many_bodies)));
  };
  EXPECT_EQ(verdict(SceneView::kMaxHands, 1), DropReason::none);
  EXPECT_EQ(verdict(SceneView::kMaxHands + 1, 1), DropReason::count);
  EXPECT_EQ(verdict(1, SceneView::kMaxBodies), DropReason::none);
  EXPECT_EQ(verdict(0, SceneView::kMaxBodies + 1), DropReason::count);
}

/// Any truncation and any flipped bit must cause no read beyond the end. Accepted bytes must give a
/// valid view.
TEST(ViewCodec, SpoiledBytesAreDroppedOrStillAView) {
  Generator random(35);
  Encoder encoder;
  const SceneView view = view_of(2, 2, random);
  const Bytes sent = encoder.reply(longest_reply(), &view);
  const std::vector<std::uint8_t> bytes(sent.begin(), sent.end());
  Reply reply;
  SceneView got;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A separate vector lets a sanitizer detect a read beyond its end.
    const std::vector<std::uint8_t> part(bytes.begin(),
                                         bytes.begin() + static_cast<std::ptrdiff_t>(size));
    decode(part, reply, &got);
  }
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::vector<std::uint8_t> spoiled = bytes;
    spoiled[bit / 8] = static_cast<std::uint8_t>(spoiled[bit / 8] ^ (1u << (bit % 8)));
    if (decode(spoiled, reply, &got) != DropReason::none || !got.present) continue;
    ASSERT_LE(got.hand_count, SceneView::kMaxHands);
    ASSERT_LE(got.body_count, SceneView::kMaxBodies);
    for (const SeenHand& hand : got.hands())
      EXPECT_TRUE(hand.pose.position.allFinite() && hand.force.allFinite() &&
                  hand.number >= got.hands_from && hand.number < got.hands_end);
    for (const SeenBody& body : got.bodies())
      EXPECT_TRUE(body.pose.position.allFinite() && body.object >= got.bodies_from &&
                  body.object < got.bodies_end);
  }
}

}  // namespace
}  // namespace feltwire::view_codec_test
