#include "server/control/session_directory.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>

#include "server/control/request_limits.hpp"

namespace feltwire {

void SessionDirectory::enter(std::uint64_t id, ListedSession session) {
  sessions_.insert_or_assign(id, std::move(session));
}

ListedSession* SessionDirectory::find(std::uint64_t id) {
  const auto found = sessions_.find(id);
  return found != sessions_.end() ? &found->second : nullptr;
}

ListedSession* SessionDirectory::find_open(const Token& token, std::uint64_t id) {
  ListedSession* session = find(id);
  return session != nullptr && opens(token, session->scene_name) ? session : nullptr;
}

ListedSession* SessionDirectory::find_own(const Token& token, std::uint64_t id) {
  ListedSession* session = find(id);
  if (session != nullptr && session->token == token.id) return session;
  return covers(token.role, Role::admin) ? find_open(token, id) : nullptr;
}

std::size_t SessionDirectory::sessions_of(const std::string& client) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      sessions_, [&](const auto& entry) { return entry.second.client == client; }));
}

std::size_t SessionDirectory::pointers() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      sessions_, [](const auto& entry) { return entry.second.role == Role::pointer; }));
}

control::SessionList SessionDirectory::list(const Token& token, std::uint64_t after) const {
  control::SessionList list;
  for (auto at = sessions_.upper_bound(after); at != sessions_.end(); ++at) {
    const ListedSession& session = at->second;
    if (!opens(token, session.scene_name)) continue;
    if (list.sessions.size() == control::kMaxSessionEntries) {
      list.more = true;
      break;
    }
    list.sessions.push_back({at->first, session.client, session.scene_name, session.role});
  }
  return list;
}

void SessionDirectory::forget(const std::vector<EndedSession>& ended, Nanoseconds now) {
  for (const auto& [id, how] : ended) {
    const auto found = sessions_.find(id);
    if (found == sessions_.end()) continue;
    const ListedSession& session = found->second;
    try {
      spdlog::info("{} left scene {} after {:.1f} s: {}", session.who, session.scene_name,
                   seconds(now - session.since), text(how));
      if (how == SessionEnd::disturbing)
        disturbers_[{session.client, session.scene}] = now + ServiceLimits::kDisturberPause;
    } catch (const std::bad_alloc&) {
      // There is no memory for the log line or for the entry in disturbers_. Remove the session
      // anyway.
    }
    sessions_.erase(found);
  }
}

bool SessionDirectory::has_disturbed(const std::string& client, std::size_t scene,
                                     Nanoseconds now) const {
  const auto disturber = disturbers_.find({client, scene});
  return disturber != disturbers_.end() && now < disturber->second;
}

}  // namespace feltwire
