#include "server/scene/client_changes.hpp"

namespace feltwire {

AskedChange next_change(const SessionSlot& slot, const ClientChange& change) {
  AskedChange next{.change = change, .parameters = slot.session.parameters(), .what = {}};
  const LawChoice before = law_of(next.parameters);
  if (slot.waits_for_client()) {
    const AskedChange& waits = *slot.asked;
    if (!waits.returns) next.parameters = waits.parameters;
    next.unheard_law = waits.unheard_law || waits.returns || waits.change.law;
    if (!change.law) next.change.law = waits.change.law;
    if (!change.link) next.change.link = waits.change.link;
  }
  if (next.change.law) next.what = difference(before, *next.change.law);
  if (next.change.link) next.what += (next.what.empty() ? "" : ", ") + text(*next.change.link);
  next.change.number = number_after(slot.asked ? slot.asked->change.number : std::uint8_t{0});
  return next;
}

void ClientChanges::hear(SessionSlot& slot, const std::optional<HandReport>& report) noexcept {
  AskedChange& asked = *slot.asked;
  if (!report || report->change != asked.change.number) return;
  asked.told = false;
  has_answers_ = true;
  const bool refused = report->change_refused;
  if (refused && asked.unheard_law) {
    // The client has refused this change. It never answered an earlier change with another law, so
    // it may use that law now. Ask it to return to the law of its session.
    asked.change = {.number = number_after(asked.change.number),
                    .law = law_of(slot.session.parameters()),
                    .link = {}};
    asked.unheard_law = false;
    asked.returns = true;
    return;
  }
  asked.answer = refused ? ChangeAnswer::refused : ChangeAnswer::taken;
  if (!refused && asked.change.law && !asked.returns) slot.session.put_law(asked.parameters);
}

std::vector<std::string> ClientChanges::answers(const SessionSlots& slots) {
  std::vector<std::string> lines;
  has_answers_ = false;
  for (const auto& slot : slots) {
    if (!slot->asked || slot->asked->told) continue;
    slot->asked->told = true;
    const std::string who =
        "session " + std::to_string(slot->number) + " (" + slot->session.client() + "): its client";
    if (!slot->asked->returns)
      lines.push_back(who + " has " + std::string(name(slot->asked->answer)) +
                      " the change: " + slot->asked->what);
    else if (slot->waits_for_client())
      lines.push_back(who + " has refused the change: " + slot->asked->what +
                      "; it is asked to return to the law of its session");
    else
      lines.push_back(who + " has " + std::string(name(slot->asked->answer)) +
                      " the return to the law of its session");
  }
  return lines;
}

}  // namespace feltwire
