#pragma once
// Takes the views of an observing program, counts them, and writes them to a file.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/run/observed_scene.hpp"
#include "client/run/view_file.hpp"
#include "client/servo/servo_loop.hpp"

namespace feltwire {

struct SightCounts {
  std::uint64_t views = 0;                      // received views
  std::size_t hands = 0, bodies = 0;            // known at present
  std::size_t most_hands = 0, most_bodies = 0;  // at once
  std::vector<LinkState> robots{};              // their states, by seat
  std::uint64_t left_out = 0;  // times that there was no room for one (ObservedScene)
};

/// "  sees 2 hands, 1 body", then ", a robot (engaged)" or ", 2 robots (engaged, ready)" if there
/// are any, and ", 3 left out" if there was not room for all.
std::string text(const SightCounts& counts);

/// Gets the time [s] of a view since the first tick, and the known scene at that time.
using OnView = std::function<void(double time, const ObservedScene& scene)>;

class ObserverRecorder {
 public:
  /// A `file` gets all views; `on_view`, if it is not empty, is called with them. Throws
  /// std::runtime_error that names the file; look() does too, and passes on the exceptions of
  /// `on_view`.
  explicit ObserverRecorder(const std::optional<std::filesystem::path>& file, OnView on_view = {});

  /// The ring into which the servo's thread puts views.
  Ring<TimedView>& views() { return views_; }
  /// Takes the waiting views.
  void look();
  /// Flushes the file, if there is one, to the disk.
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
