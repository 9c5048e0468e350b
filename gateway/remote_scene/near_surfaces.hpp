#pragma once
// The surfaces near the hands of a scene that another server computes.

#include <memory>
#include <span>
#include <vector>

#include "client/run/observed_scene.hpp"
#include "core/scene/scene.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/picture.hpp"

namespace feltwire {

/// No view carries local models. This process has the same scene, so it finds them as the server
/// does (local_model()), from the places at which hands and bodies are seen. So a hand that presses
/// is in the surface through which it was seen to come. A mesh that the client has in full is shown
/// by its patches.
class NearSurfaces {
 public:
  /// Fills PictureHand::surfaces of the first kMostPictureSurfaces hands of `picture`, which draw()
  /// made from `seen` and `told`. A hand has none if its client has no local model, if its tool has
  /// a body, or if the server does not tell of it.
  void add(const std::shared_ptr<const Scene>& scene, const ObservedScene& seen,
           std::span<const control::SessionDescription> told, Picture& picture);

 private:
  /// A tool's objects where they are seen.
  struct Surroundings {
    const ToolView* view;
    std::vector<Object> objects;
  };
  struct Hand {
    std::uint32_t number;
    std::size_t tool;
    TouchMemory memory;
  };
  void begin(const std::shared_ptr<const Scene>& scene);
  Hand& hand(std::uint32_t number, std::size_t tool);

  std::shared_ptr<const Scene> scene_;
  std::vector<Surroundings> surroundings_;  // one for each tool
  std::vector<Hand> hands_;                 // by rising number
};

}  // namespace feltwire
