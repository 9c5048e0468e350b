#pragma once
// All viewers of the live page: what each may see, and what each gets. It has no socket.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/token_file.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/web/admin_actions.hpp"
#include "server/web/page_hands.hpp"
#include "server/web/view_tickets.hpp"
#include "server/web/viewed_scene.hpp"
#include "server/web/viewer.hpp"
#include "server/web/viewer_message.hpp"
#include "server/web/viewer_slot.hpp"
#include "server/web/viewer_tokens.hpp"

namespace feltwire::web {

struct ViewerHubCounters {
  std::uint64_t viewers = 0;                     // with a valid token
  std::uint64_t refused = 0;                     // without a valid token, or too many viewers
  std::uint64_t tickets = 0;                     // issued for viewers of the Foxglove protocol
  std::uint64_t pictures = 0;                    // sent
  std::uint64_t skipped = 0;                     // turns at which a slow viewer got nothing
  std::uint64_t hands = 0;                       // requested by viewers
  std::uint64_t points = 0, points_refused = 0;  // targets of hands: taken; too far or no place
};

/// Owns the viewers, their tokens and tickets, and the scenes as viewers get them. It decides which
/// viewer may enter, and which scene each one watches.
class ViewerHub {
 public:
  using Scenes = std::vector<SceneInView*>;
  static constexpr std::size_t kMostViewers = 32;         // with a valid token
  static constexpr std::size_t kMostViewersOfClient = 8;  // of all tokens with one client's name
  static constexpr std::size_t kPlacesForAdmins = 4;      // of kMostViewers, for tokens of admins
  static constexpr std::size_t kMostMessage = 4096;       // [bytes] from a viewer

  using Reload = AdminActions::Reload;
  using WriteFlight = AdminActions::WriteFlight;
  using Record = AdminActions::Record;

  /// `io` runs on the thread that calls everything here; it, the scenes and `hands` outlive this.
  /// `hands`: the hands for viewers; null: none.
  ViewerHub(asio::io_context& io, const Scenes& scenes, TokenFile tokens,
            PageHands* hands = nullptr, AdminActions::Callbacks admins = {});
  ViewerHub(const ViewerHub&) = delete;
  ViewerHub& operator=(const ViewerHub&) = delete;

  using Id = ViewerId;
  /// A connection from `address`. The viewer must leave before its object is destroyed.
  Id join(Viewer& viewer, const asio::ip::address& address);
  void leave(Id id);
  /// It has shown a ticket, and uses the Foxglove protocol. It may have left when this returns.
  void admit(Id id, const ViewTicket& ticket);
  /// A frame of a viewer has begun: a message, a part of one, a ping, a pong or a close. Too many a
  /// second end the viewer; it may have left when this returns.
  void count(Id id);
  /// A text message of a viewer. It may have left when this returns.
  void receive(Id id, std::string_view message);

  /// A load of a scene has ended: sends a line to its viewers; only admins get the error in the
  /// file.
  void tell(std::size_t scene, const std::optional<std::string>& wrong);

  /// The name of the first scene that the token (empty: none was shown) opens and that cannot be
  /// seen now (SceneInView::out_of_sight). An empty name: the token opens none of those, or is
  /// wrong. Nothing: all are seen.
  std::optional<std::string> hidden_scene(std::string_view token);

  /// The tokens that open this page.
  ViewerTokens& tokens() { return tokens_; }

  /// A ticket for a scene, by its name; an empty name is the first scene that the token opens.
  /// Empty if the token is null, or opens no such scene.
  std::optional<Secret> mint_ticket(const Token* token, std::string_view scene);
  /// Redeems a ticket, which is void from then on. Empty: it is not good.
  std::optional<ViewTicket> redeem_ticket(std::string_view ticket);
  /// Redeems a ticket of a recording, which is void from then on: its file. Empty: it is not good.
  std::optional<std::filesystem::path> redeem_download(std::string_view ticket);

  /// Sends the news to all viewers. Call it 60 times a second while there are viewers.
  void tick(Nanoseconds now);
  bool empty() const { return slots_.empty(); }
  /// The server ends.
  void close_all();
  ViewerHubCounters counters() const;

 private:
  void admit(ViewerSlot& slot, std::string_view token);
  bool may_try_again(const ViewerSlot& slot);
  void watch(ViewerSlot& slot, std::string_view scene);
  void give_ticket(ViewerSlot& slot, std::string_view scene);
  void follow(ViewerSlot& slot, const ViewerMessage& said);
  void refuse(Id id, WebSocketClose code, const std::string& reason);
  void ping(Nanoseconds now);
  void look_after_tokens(Nanoseconds now);

  ViewerTokens tokens_;
  PageHands* hands_;
  ViewTickets tickets_;
  std::vector<std::unique_ptr<ViewedScene>> scenes_;  // viewers point to them
  ViewerSlots slots_;
  AdminActions admins_;
  Id next_id_ = 1;
  Nanoseconds looked_at_tokens_{0};
  ViewerHubCounters counters_;  // except those of the scenes
};

}  // namespace feltwire::web
