#pragma once
// What a scene looks like at one moment, for the live page, and how it leaves the scene's thread.

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

/// Reasons, known to the server, for the force that a hand feels. Several may hold at once.
enum class HandState : std::uint8_t {
  waiting,       // no sample has come yet
  silent,        // its newest sample is older than its hold time: what it felt has faded
  free_space,    // the scene asks for no force
  touching,      // it does
  gap,           // samples before the newest were lost on the way
  server_bound,  // the server's bound took something off the newest command
  saturated,     // the command was larger than the device's largest force
  refused,       // the newest movement was out of range
  recovering,    // what moves was put back to a good state and is felt in part
  client_less,   // the device holds less than the newest command, and its client says not why
  count_of_states
};
inline constexpr std::size_t kHandStates = static_cast<std::size_t>(HandState::count_of_states);
constexpr std::uint32_t bit(HandState state) { return 1u << static_cast<unsigned>(state); }
/// "server_bound"
const char* name(HandState state) noexcept;
/// For people, one sentence.
const char* text(HandState state) noexcept;
/// Whether it keeps something of the force from the hand.
bool takes_off(HandState state) noexcept;

/// Hands of one picture whose surfaces are looked up. More hands have none in it.
inline constexpr std::size_t kMostPictureSurfaces = 16;

/// One hand. World frame; forces act on the hand.
struct PictureHand {
  std::uint32_t number = 0;          // from 1 in the order they joined, never used again
  std::uint32_t states = 0;          // bits of HandState
  std::optional<HandReport> report;  // the newest that its client has said
  Pose pose;                         // of the newest sample
  Vec3 proxy = Vec3::Zero();         // [m] where the tool would be if no surface could be entered
  Vec3 elastic = Vec3::Zero();       // [N] that the scene asks for
  Vec3 frictional = Vec3::Zero();    // [N] likewise
  Vec3 held = Vec3::Zero();          // [N] that the device holds, as its client says
  double depth = 0.0;                // [m] in the object that it is deepest in
  double delivered = 0.0;            // [J] to the hand so far
  double burned = 0.0;               // [J] by the device so far, at least
  std::uint64_t samples = 0;         // taken so far
  std::uint64_t missed = 0;          // lost on the way so far
  LocalModel surfaces;               // near the tool, as its client is told them; of reach 0: none
};

struct PictureBody {
  std::uint32_t object = 0;  // its place among the scene's objects
  Pose pose;
};

struct Picture {
  Nanoseconds time{0};        // of the scene's clock
  std::uint32_t version = 0;  // of the scene: 1, and one more with each reload
  std::vector<PictureHand> hands;
  std::vector<PictureBody> bodies;
  std::optional<SeenRobot> robot;  // on the scene's seat
};

/// The facts of a hand that do not change during a session, or change slowly.
struct HandDescription {
  std::uint32_t number = 0;
  std::uint64_t session = 0;
  std::string client, device, tool;             // empty: not known
  std::optional<SessionParameters> parameters;  // nothing: not known
  ChangesTaken takes = {};                      // that an admin may change at its client
  std::string asked = {};  // for people: the newest change that its client was asked for
  ChangeAnswer answer = ChangeAnswer::waiting;  // of the client to that
  HandTimesHeard times = {};                    // of the client; not heard: not known
};

/// Brings pictures from the scene's thread to one other thread, the viewer's. Neither waits for the
/// other. Where no picture is wanted, the scene's thread only reads one atomic.
class PictureExchange {
 public:
  // The scene's thread.
  bool wanted() const noexcept { return state_.load(std::memory_order_acquire) == State::wanted; }
  /// The picture to fill. Precondition: wanted(), and give() was not called since.
  Picture& picture() noexcept { return picture_; }
  void give() noexcept { state_.store(State::given, std::memory_order_release); }

  // The viewer's thread.
  /// Copies the picture that was given since the last call, and asks for the next. False: none was
  /// given, and `picture` is as it was. The first picture after a time without calls may be old.
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
