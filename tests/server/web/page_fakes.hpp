#pragma once
// A viewer and a scene for tests of the live page that need no socket and no scene's thread.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/picture/scene_in_view.hpp"
#include "server/web/viewer.hpp"
#include "tests/server/make.hpp"

namespace feltwire::test {

/// Keeps what it is sent.
struct FakeViewer final : web::Viewer {
  void send(const std::string& text) override { texts.push_back(text); }
  void show_text(const web::SharedBytes& text) override { texts.emplace_back(text.text()); }
  void show_binary(std::span<const std::uint8_t>, const web::SharedBytes&) override { ++binaries; }
  void ping() override { ++pings; }
  bool ready() const override { return is_ready; }
  void close(WebSocketClose, std::string_view) override { closed = true; }
  void admitted() override {}

  /// Returns the texts since the last call.
  std::vector<std::string> take() { return std::exchange(texts, {}); }

  std::vector<std::string> texts;
  int binaries = 0, pings = 0;
  bool is_ready = true, closed = false;
};

/// A scene whose answers are those that a test chooses.
struct FakeScene final : SceneInView, SceneControls {
  const std::string& name() const override { return current.scene->name(); }
  CurrentScene current_scene() const override { return current; }
  bool take_picture(Picture& newest) override {
    if (!picture) return false;
    newest = *std::exchange(picture, std::nullopt);
    return true;
  }
  void describe(PostBack, std::function<void(std::vector<HandDescription>)> done) override {
    describes.push_back(std::move(done));
  }
  std::optional<std::string> out_of_sight() const override { return hidden; }
  SceneControls* controls() override { return remote ? nullptr : this; }
  void change(LiveChange change, PostBack,
              std::function<void(std::variant<std::string, control::Refused>)> done) override {
    changes.push_back(std::move(change));
    done_changes.push_back(std::move(done));
  }
  void evict(std::uint64_t session) override { evicted.push_back(session); }

  CurrentScene current{std::make_shared<const Scene>(room()), 1, 0, std::nullopt};
  std::optional<Picture> picture;
  std::optional<std::string> hidden;
  bool remote = false;
  std::vector<std::function<void(std::vector<HandDescription>)>> describes;
  std::vector<LiveChange> changes;
  std::vector<std::function<void(std::variant<std::string, control::Refused>)>> done_changes;
  std::vector<std::uint64_t> evicted;
};

}  // namespace feltwire::test
