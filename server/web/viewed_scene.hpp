#pragma once
// A scene for all its viewers.

#include <asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/net/clock.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/web/foxglove_scene.hpp"
#include "server/web/page_messages.hpp"
#include "server/web/shared_bytes.hpp"
#include "server/web/viewer_slot.hpp"

namespace feltwire::web {

/// Owns the messages about one scene, which are made once for all viewers, and the newest picture
/// and description of its hands. It is on the page's thread.
class ViewedScene {
 public:
  /// `io` runs on the page's thread; it and `scene` outlive this. `index`: the scene's place among
  /// those of the server. `begin`: time 0 of the page's clock.
  ViewedScene(asio::io_context& io, SceneInView& scene, std::size_t index, Nanoseconds begin)
      : io_(io), scene_(scene), index_(index), begin_(begin) {}
  ViewedScene(const ViewedScene&) = delete;
  ViewedScene& operator=(const ViewedScene&) = delete;

  /// Sends the news to these viewers, who watch this scene: the scene and its materials if they
  /// have changed, the newest picture, and twice a second the description of the hands. A viewer
  /// that has not taken the previous message gets nothing.
  void show(std::span<ViewerSlot* const> viewers, Nanoseconds now);

  SceneInView& source() { return scene_; }
  const std::string& name() const { return scene_.name(); }
  std::size_t index() const { return index_; }
  /// The hands as the scene described them last.
  std::vector<HandDescription>& hands() { return hands_; }
  /// Totals: pictures that were sent, and turns at which a slow viewer got nothing.
  std::uint64_t pictures() const { return pictures_; }
  std::uint64_t skipped() const { return skipped_; }

 private:
  void follow(const SceneInView::CurrentScene& current);
  void tell_of_sight(std::span<ViewerSlot* const> viewers);
  void show_scene(ViewerSlot& slot);
  void show_in_foxglove(std::span<ViewerSlot* const> viewers, Nanoseconds now, bool news);
  void count_rates();
  void describe();

  asio::io_context& io_;
  SceneInView& scene_;
  std::size_t index_;
  Nanoseconds begin_;
  // Made once for all viewers from the shown version.
  std::uint32_t version_ = 0, changes_ = 0;
  SharedBytes text_, materials_;
  std::vector<SharedBytes> geometry_;
  Picture picture_;
  std::vector<HandRates> rates_;  // by rising number
  Picture counted_;               // the picture at which the rates begin
  std::vector<HandDescription> hands_;
  Nanoseconds described_{0};
  bool describing_ = false;
  std::optional<std::string> hidden_;  // the reason why it cannot be seen, as viewers know it
  FoxgloveScene foxglove_{clock_offset()};
  std::uint64_t pictures_ = 0, skipped_ = 0;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace feltwire::web
