#include "server/web/view_tickets.hpp"

#include <algorithm>
#include <utility>

namespace feltwire::web {

void ViewTickets::forget_expired(CalendarTime now) {
  std::erase_if(waiting_, [&](const Waiting& waiting) { return expired(waiting.ticket, now); });
}

Secret ViewTickets::mint(const Token& by, const std::string& scene, CalendarTime now,
                         std::filesystem::path file) {
  forget_expired(now);
  const auto is_its = [&](const Waiting& waiting) { return waiting.by == by.id; };
  if (static_cast<std::size_t>(std::ranges::count_if(waiting_, is_its)) >= kMostOfToken)
    waiting_.erase(std::ranges::find_if(waiting_, is_its));
  IssuedToken issued = issue_token(by.client, scene, Role::observer, now + kLife);
  waiting_.push_back({std::move(issued.token), by.id, std::move(file)});
  return std::move(issued.text);
}

std::optional<ViewTicket> ViewTickets::redeem(std::string_view text, CalendarTime now) {
  forget_expired(now);
  Tokens tickets;
  for (const Waiting& waiting : waiting_) tickets.push_back(waiting.ticket);
  const Token* found = authenticate(tickets, text, now);
  if (found == nullptr) return std::nullopt;
  const auto used = std::ranges::find(waiting_, found->id, [](const Waiting& waiting) {
    return std::string_view(waiting.ticket.id);
  });
  ViewTicket opened{used->by, used->ticket.scene, used->file};
  waiting_.erase(used);
  return opened;
}

}  // namespace feltwire::web
