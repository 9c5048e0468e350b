#pragma once
// The eyes of the program that observes: takes the views, counts, and writes them down.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/run/observed_scene.hpp"
#include "client/run/view_file.hpp"
#include "client/servo/servo_loop.hpp"

namespace feltwire {

struct SightCounts {
  std::uint64_t views = 0;                      // that came
  std::size_t hands = 0, bodies = 0;            // that there are, as far as is known
  std::size_t most_hands = 0, most_bodies = 0;  // at once
  std::optional<LinkState> robot{};             // its state; nothing: there is none
  std::uint64_t left_out = 0;  // times that there was no room for one (ObservedScene)
};

/// "  sees 2 hands, 1 body", then ", a robot (engaged)" where one is seen, and ", 3 left out" where
/// there was no room for all.
std::string text(const SightCounts& counts);

/// Gets the time [s] of a view since the first tick, and all that is known of the scene by then.
using OnView = std::function<void(double time, const ObservedScene& scene)>;

class ObserverRecorder {
 public:
  /// A `file` gets what is seen; `on_view`, where it is not empty, is called with it. Throws
  /// std::runtime_error naming the file; look() does too, and passes on what `on_view` throws.
  explicit ObserverRecorder(const std::optional<std::filesystem::path>& file, OnView on_view = {});

  /// Where the servo's thread puts views.
  Ring<TimedView>& views() { return views_; }
  /// Takes what waits there.
  void look();
  /// Has the file, if there is one, be on the disk.
  void finish();

  const ObservedScene& scene() const { return scene_; }
  const SightCounts& counts() const { return counts_; }

 private:
  static constexpr std::size_t kRoom = 256;  // views: a look in 20 ms takes 200 at 10 kHz
  Ring<TimedView> views_{kRoom};
  TimedView shown_;
  ObservedScene scene_;
  SightCounts counts_;
  std::unique_ptr<ViewFile> file_;
  OnView on_view_;
};

}  // namespace feltwire
