#pragma once
// All viewers of the live page: what each may see, and what each gets. It has no socket.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/token_bucket.hpp"
#include "server/access/rate_limit.hpp"
#include "server/access/token_file.hpp"
#include "server/access/wrong_tokens.hpp"
#include "server/picture/scene_in_view.hpp"
#include "server/web/page_hands.hpp"
#include "server/web/view_tickets.hpp"
#include "server/web/viewer.hpp"
#include "server/web/viewer_message.hpp"

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

class ViewerHub {
 public:
  using Scenes = std::vector<SceneInView*>;
  static constexpr std::size_t kMostViewers = 32;         // with a valid token
  static constexpr std::size_t kMostViewersOfClient = 8;  // of all tokens with one client's name
  static constexpr std::size_t kPlacesForAdmins = 4;      // of kMostViewers, for tokens of admins
  static constexpr std::size_t kMostMessage = 4096;       // [bytes] from a viewer

  /// Reloads a scene, by its index; told() reports the result later. Empty: there is no reload.
  using Reload = std::function<void(std::size_t scene)>;

  /// Writes the flight record of a scene, by its index; `done` is called with its name, or with the
  /// reason why there is none, from any thread. Empty: there is no flight recorder.
  using WriteFlight = std::function<void(
      std::size_t scene, std::function<void(std::variant<std::string, control::Refused>)> done)>;

  /// `io` runs on the thread that calls everything here; it, the scenes and `hands` outlive this.
  /// `hands`: the hands for viewers; null: none.
  ViewerHub(asio::io_context& io, const Scenes& scenes, TokenFile tokens,
            PageHands* hands = nullptr, Reload reload = {}, WriteFlight write_flight = {});
  ~ViewerHub();

  using Id = std::uint64_t;
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

  /// Whether a text is a valid token.
  bool opens_something(std::string_view token);
  /// Counts a wrong token or ticket from this address. False: there were too many.
  bool may_try_again(const asio::ip::address& address);

  /// A ticket for a scene, by its name; an empty name is the first scene that the token opens.
  /// Empty if the token is not valid, or opens no such scene.
  std::optional<Secret> mint_ticket(std::string_view token, std::string_view scene);
  /// Redeems a ticket, which is void from then on. Empty: it is not good.
  std::optional<ViewTicket> redeem_ticket(std::string_view ticket);

  /// Sends the news to all viewers. Call it 60 times a second while there are viewers.
  void tick(Nanoseconds now);
  bool empty() const { return slots_.empty(); }
  /// The server ends.
  void close_all();
  const ViewerHubCounters& counters() const { return counters_; }

 private:
  struct ViewerSlot;
  struct Stage;
  void admit(ViewerSlot& slot, std::string_view token);
  void refresh_tokens();
  /// The token with this text, in the present file; null: there is no valid one.
  const Token* good_token(std::string_view text);
  /// Counts a wrong token. False: there were too many, so the viewer was refused.
  bool may_try_again(const ViewerSlot& slot);
  void watch(ViewerSlot& slot, std::string_view scene);
  void give_ticket(ViewerSlot& slot, std::string_view scene);
  std::optional<std::string> no_place_for(const Token& token) const;
  void enter(ViewerSlot& slot, const Token& token);
  std::optional<Secret> mint_ticket(const Token& by, std::string_view scene);
  void follow(ViewerSlot& slot, const ViewerMessage& said);
  void refuse(Id id, WebSocketClose code, const std::string& reason);
  // server/web/admin_actions.cpp
  const Token* admin_of(const ViewerSlot& slot) const;
  bool act(ViewerSlot& slot, const struct ViewerMessage& message);
  static bool only_shown(const ViewerSlot& slot);
  void become_admin(ViewerSlot& slot, std::string_view token);
  void set(ViewerSlot& slot, const struct ViewerSet& wanted);
  void change(ViewerSlot& slot, LiveChange change);
  void evict(ViewerSlot& slot, const std::string& session);
  void reload(ViewerSlot& slot);
  void write_flight(ViewerSlot& slot);
  void look_after_tokens(Nanoseconds now);
  void show(Stage& stage, Nanoseconds now);
  void tell_of_sight(Stage& stage);
  void count_rates(Stage& stage);
  void show_scene(Stage& stage, ViewerSlot& slot);
  void show_elsewhere(Stage& stage, Nanoseconds now, bool news);
  bool watched(const Stage& stage) const;

  asio::io_context& io_;
  TokenFile tokens_;
  PageHands* hands_;
  Reload reload_;
  WriteFlight write_flight_;
  RateLimit<std::string> changes_{20.0, 60.0};  // of admins' clients
  WrongTokens wrong_tokens_{0.2, 10.0};
  ViewTickets tickets_;
  std::vector<std::unique_ptr<Stage>> stages_;  // one for each scene
  std::map<Id, ViewerSlot> slots_;
  Id next_id_ = 1;
  Nanoseconds begin_, looked_at_tokens_{0};
  ViewerHubCounters counters_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace feltwire::web
