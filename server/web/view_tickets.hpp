#pragma once
// Tickets for requests that cannot send a token first: each lets one viewer watch one scene, or one
// browser fetch one recording of it. It has no socket and no clock.

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/tokens.hpp"

namespace feltwire::web {

/// The right of a ticket, on behalf of a token: to watch one scene, or to fetch one file of it.
struct ViewTicket {
  std::string token;  // its id
  std::string scene;
  std::filesystem::path file = {};  // empty: to watch
};

class ViewTickets {
 public:
  static constexpr std::chrono::seconds kLife{60};  // from minting to use
  static constexpr std::size_t kMostOfToken = 8;    // with one more the oldest becomes void

  /// Makes a ticket for a scene that the token opens, or for a file of that scene. The text is
  /// stored nowhere.
  Secret mint(const Token& by, const std::string& scene, CalendarTime now,
              std::filesystem::path file = {});
  /// Redeems a ticket, which is void from then on. Empty if the text is no ticket, or the ticket
  /// was used or is too old.
  std::optional<ViewTicket> redeem(std::string_view text, CalendarTime now);

 private:
  // A ticket is a token that opens one scene for a minute.
  struct Waiting {
    Token ticket;
    std::string by;  // the id of the token that minted it
    std::filesystem::path file;
  };
  void forget_expired(CalendarTime now);
  std::vector<Waiting> waiting_;  // the oldest first
};

}  // namespace feltwire::web
