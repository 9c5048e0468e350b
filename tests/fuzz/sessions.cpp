// A scene has two sessions, and one is hostile. For any data and requests of the hostile session,
// the other must get the answers of a session alone, bitwise. An observer must see both positions.

#include <algorithm>
#include <vector>

#include "protocol/wire/guard.hpp"
#include "protocol/wire/scene_view.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::fuzz {
namespace {

constexpr std::uint64_t kInnocent = 0x1234567800ull, kHostile = kInnocent + 256,
                        kObserver = kInnocent + 512;
constexpr std::size_t kSeats = 3;
constexpr std::size_t kSessionAt = 8;  // [bytes] offset in a header
constexpr Nanoseconds kSilence = std::chrono::seconds(2);

control::Message ask(SceneSessions& sessions, const control::Message& request, std::uint64_t id,
                     Nanoseconds now) {
  return sessions.answer(request, id, test::keys(id), now);
}

class Exchange {
 public:
  Exchange() {
    for (SceneSessions* one : {&together_, &alone_})
      require(std::holds_alternative<control::JoinAccepted>(
                  ask(*one, test::join_request(), kInnocent, now_)),
              "the innocent one joins");
    ask(together_, test::join_request(), kHostile, now_);
    control::JoinRequest eye = test::join_request();
    eye.role = Role::observer;
    ask(together_, eye, kObserver, now_);
  }

  void play(Input& in) {
    while (!in.empty()) {
      strike(in);
      speak();
      look();
    }
    require(together_.find(kInnocent) != nullptr, "the innocent one stays");
    require_counters(together_.counters());
  }

 private:
  /// Sends the innocent session's next sample, with and without the hostile session.
  void speak() {
    now_ += std::chrono::milliseconds(1);
    ++index_;
    const Bytes sent = innocent_.samples(kInnocent, index_, test::hand_batch(index_, 2));
    overheard_.assign(sent.begin(), sent.end());
    const Bytes felt = together_.receive(sent, peer_, now_, felt_);
    const Bytes expected = alone_.receive(sent, peer_, now_, expected_);
    require(!expected.empty(), "the innocent one is answered");
    require(std::equal(felt.begin(), felt.end(), expected.begin(), expected.end()),
            "an answer depends on nobody else");
  }

  void look() {
    const Bytes shown = together_.receive(
        observer_.samples(kObserver, index_, test::hand_batch(index_)), peer_, now_, felt_);
    static Reply reply;
    static SceneView view;
    require(decode(test::opened(shown, test::Way::down, test::keys(kObserver)), reply, &view) ==
                    DropReason::none &&
                view.present,
            "the observer is shown something, whatever others claim");
    require(reply.command == Command{}, "and feels nothing");
    require(view.hand_count >= 1 && view.hand_count <= 2 && view.hand[0].number == 1 &&
                (view.hand[0].pose.position - test::hand(index_).pose.position).norm() <= 1e-6,
            "the innocent one is where it is");
  }

  void strike(Input& in) {
    switch (in.byte() % 7) {
      case 0: {
        const Bytes raw = in.bytes(in.byte());
        return send({raw.begin(), raw.end()});
      }
      case 1:
        return send(own(hostile_.samples(kHostile, number(in), wild_batch(in))));
      case 2: {  // a valid seal with any payload
        const auto payload = mutated(own(encoder_.samples(test::hand_batch(1 + in.byte(), 3))), in);
        const Header header{DatagramKind::samples, kHostile, number(in)};
        return send(own(hostile_.seal(header, payload)));
      }
      case 3:  // intercepted datagrams, repeated or changed, under either id
        return send(mutated(in.coin() ? overheard_ : renamed(overheard_), in));
      case 4:
        return send(
            mutated(own(hostile_.goodbye(kHostile, number(in), GoodbyeReason::leaving)), in));
      case 5:
        return request(in);
      default:
        return wait(in);
    }
  }

  void send(const std::vector<std::uint8_t>& datagram) {
    const Bytes answer = together_.receive(datagram, peer_, now_, felt_);
    if (answer.empty()) return;
    require(answer.size() <= kMaxDatagram, "every answer fits");
    const Guarded guarded = guard(answer, test::kAllKinds);
    require(guarded.drop == DropReason::none && guarded.header.session == kHostile &&
                guarded.header.kind == DatagramKind::reply,
            "an answer is a reply, and for who asked");
    Reply reply;
    const auto payload = test::opened(answer, test::Way::down, test::keys(kHostile));
    require(decode(payload, reply) == DropReason::none, "an answer is good");
  }

  void request(Input& in) {
    SessionParameters parameters;
    parameters.mode = bounding_method_names()[in.byte() % bounding_method_names().size()];
    parameters.side = static_cast<BoundingSide>(in.byte() % kBoundingSideNames.size());
    parameters.storage = static_cast<Storage>(in.byte() % 2);
    parameters.redundancy = in.byte() % (kMaxRedundancy + 1);
    parameters.local_model = in.coin();
    if (in.coin()) parameters.operator_damping = in.any_double();
    if (in.coin()) parameters.velocity_cutoff = in.any_double();
    if (in.coin()) parameters.c1 = in.any_double();
    if (in.coin()) parameters.force_deadband = std::abs(in.number(kMaxDeadband));
    if (in.coin()) parameters.predictor = Predictor::linear;
    switch (in.byte() % 4) {
      case 0:
        ask(together_, control::LeaveRequest{kHostile}, 0, now_);
        break;
      case 1: {
        control::JoinRequest join = test::join_request(parameters);
        if (in.coin()) join.device.damping = in.any_double();
        if (in.coin()) join.device.max_force = in.any_double();
        if (in.coin()) join.device.rotation_sensed = join.device.rotation_actuated = 3;
        if (in.coin()) join.role = Role::observer;
        const control::Message answer = ask(together_, join, kHostile, now_);
        require(std::holds_alternative<control::JoinAccepted>(answer) ||
                    std::holds_alternative<control::Refused>(answer),
                "a join is granted or refused");
        break;
      }
      default:
        ask(together_, control::SetParameters{kHostile, parameters}, 0, now_);
    }
    require(together_.size() <= kSeats, "there are no more sessions than seats");
  }

  void wait(Input& in) {
    now_ += std::chrono::milliseconds(in.byte());
    for (const auto& farewell : together_.expire(now_))
      require(guard(farewell.datagram, test::kAllKinds).header.session == kHostile,
              "only who is silent is sent away");
    alone_.expire(now_);
  }

  static SampleBatch wild_batch(Input& in) {
    SampleBatch b;
    b.count = 1 + in.byte() % (kMaxRedundancy + 1);
    b.rotation = in.coin();
    std::uint64_t index = in.coin() ? in.whole<std::uint64_t>() : 16 + in.whole<std::uint16_t>();
    for (int i = 0; i < b.count; ++i) {
      Sample& s = b.samples[static_cast<std::size_t>(i)];
      s.index = index--;
      s.client_time = Nanoseconds(in.whole<std::int64_t>());
      s.pose.position = in.coin() ? in.vector(0.1) : in.vector(kMaxPosition);
      s.held.elastic = {in.any_float(), in.any_float(), in.any_float()};
      s.held.frictional = in.vector(10.0);
    }
    b.previous = in.coin() ? 0 : index;
    return b;
  }

  std::uint64_t number(Input& in) {
    return in.byte() == 0 ? in.whole<std::uint64_t>() : ++hostile_number_;
  }

  static std::vector<std::uint8_t> own(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

  static std::vector<std::uint8_t> renamed(std::vector<std::uint8_t> datagram) {
    if (datagram.size() <= kSessionAt + 1) return datagram;
    datagram[kSessionAt + 1] =
        static_cast<std::uint8_t>(datagram[kSessionAt + 1] + (kHostile - kInnocent) / 256);
    return datagram;
  }

  static std::vector<std::uint8_t> mutated(std::vector<std::uint8_t> datagram, Input& in) {
    for (int changes = datagram.empty() ? 0 : in.byte() % 4; changes > 0; --changes)
      datagram[in.whole<std::uint16_t>() % datagram.size()] = in.byte();
    if (in.byte() % 8 == 0) datagram.resize(in.whole<std::uint16_t>() % (kMaxDatagram + 8));
    return datagram;
  }

  static void require_counters(const SceneCounters& counters) {
    std::uint64_t accounted =
        counters.samples.replies + counters.samples.withheld + counters.late_goodbyes;
    for (const std::uint64_t dropped : counters.drops) accounted += dropped;
    require(accounted <= counters.datagrams && counters.datagrams <= accounted + counters.left,
            "every datagram is answered, withheld, a goodbye, or dropped and counted");
  }

  const Scene scene_ = test::room();
  SceneSessions together_{scene_, kSilence, kSeats}, alone_{scene_, kSilence, kSeats};
  test::SealedEncoder innocent_{test::Way::up}, hostile_{test::Way::up, test::keys(kHostile)},
      observer_{test::Way::up, test::keys(kObserver)};
  Encoder encoder_;
  DatagramBuffer felt_, expected_;
  std::vector<std::uint8_t> overheard_;
  Peer peer_;
  Nanoseconds now_{0};
  std::uint64_t index_ = 0, hostile_number_ = 0;
};

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  feltwire::fuzz::Input in(data, size);
  feltwire::fuzz::Exchange().play(in);
  return 0;
}
