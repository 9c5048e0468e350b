#pragma once
// The state of a scene at one moment, for the live page, and its way out of the scene's thread.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/local_model/local_model.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/scene_view.hpp"

namespace feltwire {

/// Reasons for the force on a hand, as far as the server knows them. Several may apply at once.
enum class HandState : std::uint8_t {
  waiting,       // no sample has come yet
  silent,        // its newest sample is older than its hold time: its force has faded
  free_space,    // the scene commands no force
  touching,      // the scene commands a force
  gap,           // samples before the newest were lost on the way
  server_bound,  // the server's bound reduced the newest command
  saturated,     // the command was larger than the device's largest force
  refused,       // the newest movement was out of range
  recovering,    // moving objects were put back to a good state and are felt in part
  client_less,   // the device holds less than the newest command, and its client gives no reason
  moves_robot,   // it moves a robot, and feels what the robot touches
  count_of_states
};
inline constexpr std::size_t kHandStates = static_cast<std::size_t>(HandState::count_of_states);
constexpr std::uint32_t bit(HandState state) { return 1u << static_cast<unsigned>(state); }
/// "server_bound"
const char* name(HandState state) noexcept;
/// For people, one sentence.
const char* text(HandState state) noexcept;
/// Whether it reduces the force on the hand.
bool takes_off(HandState state) noexcept;

/// Hands of one picture with surfaces. Further hands have none.
inline constexpr std::size_t kMostPictureSurfaces = 16;

/// A hand. World frame; forces act on the hand.
struct PictureHand {
  std::uint32_t number = 0;          // from 1 in the order they joined, never used again
  std::uint32_t states = 0;          // bits of HandState
  std::optional<HandReport> report;  // the newest one of its client
  Pose pose;                         // of the newest sample
  Vec3 proxy = Vec3::Zero();         // [m] place of the tool if it could enter no surface
  Vec3 elastic = Vec3::Zero();       // [N] commanded by the scene
  Vec3 frictional = Vec3::Zero();    // [N] commanded by the scene
  Vec3 held = Vec3::Zero();          // [N] held by the device, as its client reports
  double depth = 0.0;                // [m] in the object in which it is deepest
  double delivered = 0.0;            // [J] to the hand so far
  double burned = 0.0;               // [J] lower bound of the device's burned energy so far
  std::uint64_t samples = 0;         // taken so far
  std::uint64_t missed = 0;          // lost on the way so far
  LocalModel surfaces;               // near the tool, as sent to its client; of reach 0: none
};

struct PictureBody {
  std::uint32_t object = 0;  // its index in the scene
  Pose pose;
};

struct Picture {
  Nanoseconds time{0};        // of the scene's clock
  std::uint32_t version = 0;  // of the scene: 1, and one more with each reload
  std::vector<PictureHand> hands;
  std::vector<PictureBody> bodies;
  std::vector<SeenRobot> robots;  // on the scene's seats, by rising seat
};

/// The properties of a hand that do not change during a session, or change slowly.
struct HandDescription {
  std::uint32_t number = 0;
  std::uint64_t session = 0;
  std::string client, device, tool;             // empty: not known
  std::optional<SessionParameters> parameters;  // nothing: not known
  ClientChangeState changes = {};
  HandTimesHeard times = {};               // of the client; not heard: not known
  std::optional<double> lead_share = {};   // of its robot; nothing: it can lead none
  std::optional<Nanoseconds> joined = {};  // of the pictures' clock; nothing: not known
};

/// Brings pictures from the scene's thread to one other thread, the viewer's. Neither waits for the
/// other. If no picture is wanted, the scene's thread only reads one atomic.
class PictureExchange {
 public:
  // The scene's thread.
  bool wanted() const noexcept { return state_.load(std::memory_order_acquire) == State::wanted; }
  /// The picture to fill. Precondition: wanted(), and give() was not called since.
  Picture& picture() noexcept { return picture_; }
  void give() noexcept { state_.store(State::given, std::memory_order_release); }

  // The viewer's thread.
  /// Copies the newest picture since the last call, and requests the next. False: there was none,
  /// and `picture` is unchanged. The first picture after a time without calls may be old.
  bool take(Picture& picture) {
    const State state = state_.load(std::memory_order_acquire);
    if (state == State::wanted) return false;
    if (state == State::given) picture = picture_;
    state_.store(State::wanted, std::memory_order_release);
    return state == State::given;
  }

 private:
  enum class State : std::uint8_t { idle, wanted, given };
  std::atomic<State> state_{State::idle};
  Picture picture_;
};

}  // namespace feltwire
