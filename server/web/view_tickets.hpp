#pragma once
// Tickets for viewers that cannot send a token first: each lets one viewer look at one scene. No
// socket, no clock.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/tokens.hpp"

namespace feltwire::web {

/// The right that a ticket gives: to look at one scene, on behalf of a token.
struct ViewTicket {
  std::string token;  // its id
  std::string scene;
};

class ViewTickets {
 public:
  static constexpr std::chrono::seconds kLife{60};  // from minting to use
  static constexpr std::size_t kMostOfToken = 8;    // then its oldest is void

  /// A ticket for a scene that the token opens. The text is written down nowhere.
  Secret mint(const Token& by, const std::string& scene, CalendarTime now);
  /// Redeems a ticket: it is void from then on. Nothing where the text is no ticket, or the ticket
  /// was used or is too old.
  std::optional<ViewTicket> redeem(std::string_view text, CalendarTime now);

 private:
  // A ticket is a token that opens one scene for a minute.
  struct Waiting {
    Token ticket;
    std::string by;  // the id of the token that minted it
  };
  void forget_expired(CalendarTime now);
  std::vector<Waiting> waiting_;  // the oldest first
};

}  // namespace feltwire::web
