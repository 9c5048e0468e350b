#pragma once
// A session: a device in a scene, from its samples to the commands that answer them. It has no
// socket and no clock.

#include <optional>

#include "core/bounding/bounding.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/bounding/velocity.hpp"
#include "core/dynamics/world.hpp"
#include "core/local_model/body_model.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene/scene.hpp"
#include "core/tool/body_tool.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/datagram.hpp"
#include "server/scene/reply_deadband.hpp"

namespace feltwire {

struct SessionCounters {
  std::uint64_t samples = 0;     // taken, each once
  std::uint64_t replies = 0;     // sent
  std::uint64_t withheld = 0;    // replies that the client does not need (force deadband)
  std::uint64_t gaps = 0;        // places where samples that travelled were lost
  std::uint64_t missed = 0;      // in these, up to the last that travelled; left out ones included
  std::uint64_t duplicates = 0;  // datagrams without a new sample
  std::uint64_t late_ticks = 0;  // servo ticks that came a whole period late, as its client reports
};

/// The limits of a hand with this device on moving objects: the force that the device can give to
/// the hand, and the speed of a fast hand.
inline HandLimits hand_limits(const DeviceSpec& device) {
  return {.force = device.max_force, .speed = kFastestHand};
}

/// The outcome of the newest sample, for a picture of the scene. World frame.
struct SampleOutcome {
  Command asked;  // by the scene, before the server's bound
  bool bounded = false, saturated = false, refused = false, gap = false;  // as in Reply
};

/// The place of a tool if it could enter no surface [m, world], and its depth [m] in the object in
/// which it is deepest.
struct ProxyPlace {
  Vec3 position = Vec3::Zero();
  double depth = 0.0;
};

/// The result of a batch. `reply` is valid if `drop` is none. It is sent unless `withheld`.
struct BatchResult {
  DropReason drop = DropReason::none;
  bool withheld = false;
  Reply reply;
};

/// For people: why a client cannot have this object in full.
std::string no_surface(std::uint16_t object);

class Session {
 public:
  /// The scene's view for the tool of the hand (Scene::view) must outlive the session, and so must
  /// the `world`, the one simulation of the scene if anything moves. Throws std::invalid_argument
  /// that names the field, the value and the remedy if the device, the parameters or both together
  /// are not possible.
  Session(const control::JoinRequest& request, const ToolView& view, World* world = nullptr);

  /// Takes the new samples, oldest first, and answers the newest. `now` [ns] is the server's
  /// monotonic clock and only goes into the reply: the computation depends on the samples alone. A
  /// dropped batch leaves everything unchanged, also a held contact. Precondition: none; check() is
  /// repeated here. Never allocates.
  BatchResult take(const SampleBatch& batch, Nanoseconds now) noexcept;

  /// Takes so much out of the reply's model that the reply is about `excess` [bytes] shorter: the
  /// farthest surfaces, the finest parts of a tool with a body, in the end the model. Precondition:
  /// a reply of this session's newest sample. Returns false if it has no model any more. Never
  /// allocates.
  bool shorten(Reply& reply, std::size_t excess) const noexcept;

  /// Applies the hand's force to the moving objects, for the next step of the world: in full until
  /// half of hold_time after its newest sample, then fading to zero at hold_time, as the command
  /// does. `age` [s] of that sample. Precondition: the session has a world.
  void push(double age) noexcept;

  /// After a bad step of the world: World::blame() of this hand.
  double blame() const noexcept {
    return place_.world == nullptr ? 0.0 : place_.world->blame(place_.body_contacts);
  }

  /// A scene and its world for a hand that has not touched anything in them yet. Both must outlive
  /// the sessions in them. Allocates.
  struct Place {
    Place() = default;
    Place(const ToolView& entered, World* run, const HandLimits& limits = {});
    const ToolView* view = nullptr;
    World* world = nullptr;  // null: nothing moves
    TouchMemory contacts;
    BodyContactState body_contacts;
  };
  /// The hand is in another scene from its next sample on; its force comes from the same bound.
  /// Precondition: the place has a view.
  void enter(Place place) noexcept;
  /// Takes another material of one object of the scene, from the next sample on: contacts
  /// continue, and the force comes from the same bound. The client gets the same message as for a
  /// reload, because the surface under its hand has changed. A stick point begins anew if a surface
  /// without friction gets friction. Precondition: the view is of the same tool.
  void adopt(const ToolView& view, std::size_t object) noexcept;
  /// The scene has another gravity from the next sample on. The client of a tool with a body gets
  /// the same message as for adopt(), because it may move the tool itself.
  void weigh_anew() noexcept;
  /// From the next sample on the client has these objects in full, of this version, and no others;
  /// with a tool that has a body it has the tool, too. Returns the error of a false object, and
  /// then changes nothing. Allocates.
  std::optional<std::string> take_surfaces(std::uint32_t version,
                                           const std::vector<std::uint16_t>& objects);
  /// The limits of this hand on moving objects.
  HandLimits limits() const { return hand_limits(device_); }

  /// Whether the hand is at an arm of this world from the next sample on: then it touches the scene
  /// with the arm, and with nothing else. Its contacts begin anew when it comes back.
  void reach_through_arm(bool through) noexcept;

  /// Counts a datagram of this session with a packet number that was seen before.
  void count_duplicate() noexcept { ++counters_.duplicates; }

  /// Puts other parameters in force from the next sample on. If the bound changes (mode,
  /// projection, side, damping credit, constants) it starts anew from zero held force: the command
  /// drops to zero and grows again as the hand presses on. Zero is admissible in every mode, and
  /// the movement before its first sample is not credited to the new bound (the old one's storage
  /// paid for it), so the change itself gives the hand no energy. Throws std::invalid_argument and
  /// changes nothing if they are not possible or the servo period differs.
  void set_parameters(const SessionParameters& parameters);
  /// The client has taken another law. `parameters` are those in force with that law; it receives
  /// the previous ones. Precondition: the client bounds, before and after. Never allocates.
  void put_law(SessionParameters& parameters) noexcept;

  const SessionParameters& parameters() const { return parameters_; }
  const DeviceSpec& device() const { return device_; }
  const std::string& client() const { return client_; }
  const SessionCounters& counters() const { return counters_; }
  /// Whether it feels nothing and acts on nothing: an observer gets the scene instead, a robot its
  /// targets.
  bool observes() const { return observes_; }
  /// The newest sample taken; its index is 0 before the first.
  const Sample& newest() const { return newest_.sample; }

  /// All false and zero before the first sample.
  const SampleOutcome& outcome() const { return newest_.outcome; }
  /// The newest report of its client; empty: nothing yet.
  const std::optional<HandReport>& report() const { return report_; }
  const HandTimesHeard& times() const { return times_; }
  /// The proxy at the newest sample. It computes the touched surfaces again, so do not call it at
  /// every sample. Precondition: there is a sample.
  ProxyPlace proxy() const noexcept;

  /// The surfaces near the tool at the newest sample, as sent to its client. Of reach 0 if the
  /// session has no local model. Precondition: there is a sample.
  LocalModel surfaces() const noexcept;

  /// [J] lower bound of the energy that the device burned so far.
  double burned() const { return observer_.burned(); }
  /// At the real port, from the held forces that the client reported. It is an estimate, because
  /// the server does not know samples that did not travel. Only the client can tell whether a bound
  /// held.
  const ChannelEnergy& delivered() const { return observer_.delivered(); }

 private:
  struct Movement;
  /// The bound, if the server bounds.
  struct Bound {
    Bounding bounding;
    bool fresh = false;  // it has not stepped yet, the session has
    Vec3 probe_offset =
        Vec3::Zero();  // [m] from the device to the place where the scene was evaluated last
  };
  /// The newest sample taken.
  struct Newest {
    Sample sample;          // index 0: none taken yet
    bool rotation = false;  // it had an orientation
    SampleOutcome outcome;
  };
  /// The objects that the client has in full.
  struct Prefetched {
    KnownSurfaces known;
    std::uint32_t version = 0;  // and that of the tool's body; 0: it has none
  };
  bool touches() const noexcept { return !observes_ && !through_arm_; }
  LocalModel model() const noexcept;
  void forget_surfaces() noexcept;
  BodyModel body_model(int most = kMaxBodyPoints) const noexcept;
  Command touch(const Pose& device, const Tool& tool, double elapsed) noexcept;
  Movement movement_to(const Sample& sample, bool rotation) const noexcept;
  void hear(const HandReport& report) noexcept;
  void count_gap(const SampleBatch& batch, Reply& reply) noexcept;
  void step(const Sample& sample, bool rotation, Reply& reply) noexcept;

  std::string client_;
  DeviceSpec device_;
  SessionParameters parameters_;
  bool observes_;             // it feels nothing and acts on nothing
  bool sends_normals_;        // the client shapes late forces, wall by wall
  bool through_arm_ = false;  // it touches with an arm of the world

  Place place_;
  std::uint32_t scenes_ = 1;  // number of scenes so far, with this one
  Prefetched prefetched_;
  BodyMemory body_;
  Bound bound_;
  VelocityEstimate velocity_;
  PortEnergy observer_;
  ReplyDeadband deadband_;

  std::uint8_t reloads_ = 0;  // of the scene, modulo 256
  Newest newest_;
  std::optional<HandReport> report_;
  HandTimesHeard times_;
  SessionCounters counters_;
};

}  // namespace feltwire
