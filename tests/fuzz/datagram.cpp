// Takes arbitrary bytes as a datagram on both sides. An accepted datagram must keep each guarantee
// of PROTOCOL.md, and must be equal after it is encoded again.

#include <algorithm>
#include <vector>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"
#include "tests/fuzz/same_datagram.hpp"

namespace feltwire::fuzz {
namespace {

constexpr unsigned kServerTakes =
    set_of({DatagramKind::samples, DatagramKind::goodbye, DatagramKind::follower_state});
constexpr unsigned kClientTakes =
    set_of({DatagramKind::reply, DatagramKind::goodbye, DatagramKind::follower_target});

/// A payload at an unaligned address.
class Unaligned {
 public:
  explicit Unaligned(Bytes payload) : bytes_(1) {
    bytes_.insert(bytes_.end(), payload.begin(), payload.end());
  }
  Bytes payload() const { return Bytes(bytes_).subspan(1); }

 private:
  std::vector<std::uint8_t> bytes_;
};

void require_promises(const SampleBatch& batch) {
  require(batch.count >= 1 && batch.count <= kMaxRedundancy + 1, "1 to 9 samples");
  require(check(batch) == DropReason::none, "decode() judges as check() does");
  std::uint64_t above = 0;
  for (const Sample& sample : batch.view()) {
    require(sample.index > batch.previous && (above == 0 || sample.index < above),
            "indices fall strictly");
    above = sample.index;
    require(sample.held.finite(), "held forces are finite");
    require(sample.pose.position.allFinite() &&
                sample.pose.position.cwiseAbs().maxCoeff() <= kMaxPosition,
            "positions lie where hands are");
    require(std::abs(sample.pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance,
            "orientations are unit");
  }
}

void try_samples(Bytes payload) {
  static Encoder encoder;
  static SampleBatch batch, again;
  const DropReason drop = decode(payload, batch);
  require(decode(Unaligned(payload).payload(), again) == drop, "alignment changes nothing");
  if (drop != DropReason::none) return;
  require(same(batch, again), "alignment changes no value");
  require_promises(batch);
  const Bytes sent = encoder.samples(batch);
  require(sent.size() <= kMaxPayload, "no datagram is longer than the limit");
  require(decode(sent, again) == DropReason::none && same(batch, again),
          "samples say the same when they are sent again");
}

void require_promises(const Reply& reply) {
  require(reply.sample_index > 0 && reply.command.finite() && reply.rates.finite(),
          "commands are finite and answer a sample");
  require(std::isfinite(reply.bound.ratio) && std::isfinite(reply.delivered.elastic) &&
              std::isfinite(reply.delivered.frictional) && std::isfinite(reply.delivered.torque),
          "reports are finite");
  if (reply.change)
    require(reply.change->number >= 1 && reply.change->number <= ClientChange::kLast &&
                (!reply.change->link || possible(*reply.change->link)),
            "changes are possible");
  if (!reply.modelled) return;
  require(reply.model.count >= 0 && reply.model.count <= kMaxPatches, "0 to 3 patches");
  for (const SurfacePatch& patch : reply.model.view())
    require(patch.point.allFinite() && patch.anchor.allFinite() &&
                std::abs(patch.normal.squaredNorm() - 1.0) <= kUnitTolerance &&
                patch.material.stiffness > 0.0 &&
                patch.material.static_friction >= patch.material.dynamic_friction,
            "patches are surfaces");
}

void require_promises(const SceneView& view) {
  if (!view.present) return;
  require(view.hand_count <= SceneView::kMaxHands && view.body_count <= SceneView::kMaxBodies,
          "no more than a view may have");
  const auto pose = [](const Pose& p) {
    return p.position.allFinite() && std::abs(p.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
  };
  std::uint64_t least = view.hands_from;
  for (const SeenHand& hand : view.hands()) {
    require(pose(hand.pose) && hand.force.allFinite(), "hands are somewhere");
    if (const auto& f = hand.figures)
      require(view.hand_count <= SceneView::kMaxFigures && f->proxy.allFinite() &&
                  f->elastic.allFinite() && f->frictional.allFinite() && std::isfinite(f->depth) &&
                  std::isfinite(f->delivered) && std::isfinite(f->burned) &&
                  (!f->report || f->report->finite()),
              "figures are finite");
    require(hand.number >= least && hand.number < view.hands_end, "hands rise within their range");
    least = std::uint64_t{hand.number} + 1;
  }
  least = view.bodies_from;
  for (const SeenBody& body : view.bodies()) {
    require(pose(body.pose), "bodies are somewhere");
    require(body.object >= least && body.object < view.bodies_end,
            "bodies rise within their range");
    least = std::uint64_t{body.object} + 1;
  }
}

void try_reply(Bytes payload) {
  static Encoder encoder;
  static Reply reply, again;
  static SceneView view, view_again;
  const DropReason drop = decode(payload, reply, &view);
  require(decode(Unaligned(payload).payload(), again, &view_again) == drop,
          "alignment changes nothing");
  require(decode(payload, again) == drop, "a view is judged whether or not it is wanted");
  if (drop != DropReason::none) return;
  require(decode(Unaligned(payload).payload(), again, &view_again) == drop, "twice the same");
  require(same_but_model(reply, again) && same(view, view_again), "alignment changes no value");
  require_promises(reply);
  require_promises(view);
  reply.modelled = false;  // A model with a far center loses digits (see datagram_round_trip).
  const Bytes sent = encoder.reply(reply, view.present ? &view : nullptr);
  require(sent.size() <= kMaxPayload || view.present, "no datagram is longer than the limit");
  if (sent.size() > kMaxPayload) return;  // No server sends so many hands and bodies.
  require(decode(sent, again, &view_again) == DropReason::none && same_but_model(reply, again) &&
              same(view, view_again),
          "a reply says the same when it is sent again");
}

void try_goodbye(Bytes payload) {
  static Encoder encoder;
  GoodbyeReason reason{}, again{};
  if (decode(payload, reason) != DropReason::none) return;
  require(decode(encoder.goodbye(reason), again) == DropReason::none && reason == again,
          "a goodbye says the same when it is sent again");
}

/// Tries the bytes as a robot's state or target.
template <class Said>
void try_robot(Bytes payload, Bytes (Encoder::*encode)(const Said&)) {
  static Encoder encoder;
  Said said, again;
  const DropReason drop = decode(payload, said);
  require(decode(Unaligned(payload).payload(), again) == drop, "alignment changes nothing");
  if (drop != DropReason::none) return;
  require(same(said, again), "alignment changes no value");
  require(said.index > 0 && said.pose.position.cwiseAbs().maxCoeff() <= kMaxPosition &&
              std::abs(said.pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance,
          "robots and targets are somewhere");
  require(decode((encoder.*encode)(said), again) == DropReason::none && same(said, again),
          "what is said of a robot is the same when it is sent again");
}

void try_side(Bytes datagram, unsigned kinds) {
  const Guarded guarded = guard(datagram, kinds);
  if (guarded.drop != DropReason::none) return;
  require((set_of({guarded.header.kind}) & kinds) != 0, "only expected kinds pass");
  std::array<std::uint8_t, kHeaderSize> header{};
  write_header(header, guarded.header);
  require(std::equal(header.begin(), header.end(), datagram.begin()), "one header, one reading");
  static Opener opener(CipherSuite::chacha20_poly1305, Key{});
  static DatagramBuffer out;
  require(opener.open(guarded.header, datagram, out).drop != DropReason::none,
          "what nobody sealed is not opened");
}

/// Tries the bytes as an opened payload.
void try_payload(Bytes payload) {
  if (payload.size() > kMaxPayload) return;
  try_samples(payload);
  try_reply(payload);
  try_goodbye(payload);
  try_robot<RobotState>(payload, &Encoder::state);
  try_robot<RobotTarget>(payload, &Encoder::target);
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  fuzz::try_side({data, size}, fuzz::kServerTakes);
  fuzz::try_side({data, size}, fuzz::kClientTakes);
  fuzz::try_payload({data, size});
  if (size > kHeaderSize) fuzz::try_payload({data + kHeaderSize, size - kHeaderSize});
  return 0;
}
