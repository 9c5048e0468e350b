#pragma once
// The actions of admins on the live page: changes, evictions, reloads, flight records, recordings.

#include <asio/io_context.hpp>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "protocol/session/live_change.hpp"
#include "protocol/wire/control.hpp"
#include "server/access/rate_limit.hpp"
#include "server/web/view_tickets.hpp"
#include "server/web/viewer_message.hpp"
#include "server/web/viewer_slot.hpp"
#include "server/web/viewer_tokens.hpp"

namespace feltwire::web {

/// Handles each action like the same request at the control port. Owns the limit on changes of each
/// client. It is on the page's thread.
class AdminActions {
 public:
  /// Reloads a scene, by its index; ViewerHub::tell() reports the result later. Empty: there is no
  /// reload.
  using Reload = std::function<void(std::size_t scene)>;
  /// Writes the flight record of a scene, by its index; `done` is called with its name, or with the
  /// reason why there is none, from any thread. Empty: there is no flight recorder.
  using WriteFlight = std::function<void(
      std::size_t scene, std::function<void(std::variant<std::string, control::Refused>)> done)>;

  /// Starts or stops a recording of a scene, by its index, or only looks; `done` is called from any
  /// thread. Empty: admins start no recordings.
  using Record = std::function<void(
      std::size_t scene, control::RecordingAction action,
      std::function<void(std::variant<control::SceneRecordings, control::Refused>)> done)>;

  struct Callbacks {
    Reload reload = {};
    WriteFlight write_flight = {};
    Record record = {};
  };

  /// `io` runs on the page's thread; it, `tokens`, `tickets` and `viewers` outlive this. An answer
  /// that comes later goes to a viewer of `viewers`; a viewer that has left meanwhile gets none.
  AdminActions(asio::io_context& io, ViewerTokens& tokens, ViewTickets& tickets,
               ViewerSlots& viewers, Callbacks callbacks);
  AdminActions(const AdminActions&) = delete;
  AdminActions& operator=(const AdminActions&) = delete;

  /// `wrong_token`: the message has a token that is not valid, and the viewer has no answer yet.
  enum class Outcome { not_asked, handled, wrong_token };
  /// Does what the message asks for and answers the viewer. `not_asked`: it asks for no action.
  Outcome handle(ViewerSlot& slot, const ViewerMessage& message);

  /// Sends the admins what has changed of the recordings of their scenes. Call it often; it asks
  /// once a second.
  void look_after(Nanoseconds now);

  /// Redeems a ticket for a recording, which is void from then on. Empty: it is not good, or its
  /// token is no admin's any more.
  std::optional<std::filesystem::path> redeem_download(std::string_view ticket);

  /// Whether the viewer is an admin of the scene that it watches.
  bool is_admin(const ViewerSlot& slot) const { return admin_token(slot) != nullptr; }

 private:
  const Token* admin_token(const ViewerSlot& slot) const;
  Outcome become_admin(ViewerSlot& slot, std::string_view token);
  void set(ViewerSlot& slot, const ViewerSet& wanted);
  void change(ViewerSlot& slot, LiveChange change);
  void evict(ViewerSlot& slot, const std::string& session);
  void reload(ViewerSlot& slot);
  void write_flight(ViewerSlot& slot);
  void record(ViewerSlot& slot, const std::string& action);
  void give_download(ViewerSlot& slot, const std::string& name);
  using Recordings = std::variant<control::SceneRecordings, control::Refused>;
  template <class Take>
  void ask_recorder(std::size_t scene, control::RecordingAction action, Take take);
  void show(std::size_t scene, const control::SceneRecordings& recordings);
  std::string author(const ViewerSlot& slot) const;
  void answer(ViewerId id, const std::string& text);

  asio::io_context& io_;
  ViewerTokens& tokens_;
  ViewTickets& tickets_;
  ViewerSlots& viewers_;
  Callbacks callbacks_;
  Nanoseconds looked_{0};                       // at the recordings
  RateLimit<std::string> changes_{20.0, 60.0};  // [1/s] of a client, and at once
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace feltwire::web
