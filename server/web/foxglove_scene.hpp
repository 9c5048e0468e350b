#pragma once
// A scene for viewers of the Foxglove protocol, encoded once for all of them. It has no socket.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "server/picture/picture.hpp"
#include "server/web/foxglove_messages.hpp"
#include "server/web/shared_bytes.hpp"

namespace feltwire::web {

/// The newest message of a channel.
struct FoxgloveTopic {
  SharedBytes payload;         // Protobuf
  std::uint64_t time = 0;      // [ns] since 1970
  std::uint64_t revision = 0;  // 0: there was none yet; rises with each message
};

class FoxgloveScene {
 public:
  /// `since_1970` [ns]: from the scenes' clock to the time since 1970.
  explicit FoxgloveScene(std::int64_t since_1970) : since_1970_(since_1970) {}

  /// Takes another version of the scene. Bodies are at their places in the file until a picture has
  /// others. Nothing happens if this version is known. Allocates, and may take some 10 ms.
  void set(const Scene& scene, std::uint32_t version, Nanoseconds now);
  /// A picture of this version.
  void set(const Picture& picture);

  const FoxgloveTopic& topic(FoxgloveChannel channel) const {
    return topics_[static_cast<std::size_t>(channel)];
  }
  /// The hands of the newest picture, by rising number.
  const std::vector<std::uint32_t>& hands() const { return hands_; }

 private:
  std::uint64_t time_of(Nanoseconds clock) const {
    return static_cast<std::uint64_t>(clock.count() + since_1970_);
  }
  void put(FoxgloveChannel channel, std::uint64_t time, std::string payload);
  std::int64_t since_1970_;
  std::uint32_t version_ = 0;
  std::array<FoxgloveTopic, kFoxgloveChannels> topics_;
  std::vector<std::uint32_t> hands_;
};

/// The name of a hand in /scene/picture: "hand 3".
std::string foxglove_hand_id(std::uint32_t number);

}  // namespace feltwire::web
