#include "client/run/session_supervisor.hpp"

#include <exception>

#include "client/run/status_line.hpp"

namespace feltwire {

bool SessionSupervisor::look() noexcept {
  const bool running = !parts_.thread.over();
  LiveStatus status;
  bool fresh = false;
  while (parts_.statuses.pop(status)) fresh = true;
  parts_.records.write();
  tell_of_changes();
  if (fresh) show(status);
  const bool lost = fresh && connected_ && !status.connected;
  if (fresh) connected_ = status.connected;
  if (running) parts_.reconnector.look(connected_, Reconnector::Clock::now());
  if (fresh) parts_.fetch.in_use(status.scene.fetched);
  follow_session();
  if (running && fresh && connected_)
    parts_.fetch.look({session_, status.scene.reloads}, SceneFetch::Clock::now());
  tell_of_fetch();
  if (lost) write_flight_record("the session was lost");
  if (!parts_.reconnector.refusal().empty()) parts_.thread.stop();
  return running;
}

/// Has the scene fetched for the newest session, from its host.
void SessionSupervisor::follow_session() noexcept {
  const std::uint64_t newest = parts_.reconnector.session();
  if (session_ == 0 || newest == 0 || newest == session_) return;
  try {
    parts_.fetch.put_server(parts_.reconnector.host());
    session_ = newest;
  } catch (const std::exception&) {  // no memory: the next call tries again
  }
}

void SessionSupervisor::write_flight_record(const char* cause) noexcept {
  try {
    if (const auto file = parts_.records.write_flight_record(cause))
      outlet_.say(std::string(cause) + "; flight record: " + file->string());
  } catch (const std::exception&) {  // no memory to say so
  }
}

void SessionSupervisor::show(const LiveStatus& status) noexcept {
  try {
    const auto sight = parts_.records.sight();
    std::string more = sight ? text(*sight) : std::string();
    if (!parts_.fetch.refusal().empty()) more += "  contact not computed here";
    outlet_.show(status, more);
  } catch (const std::exception&) {  // no memory for this message
  }
}

/// Reports and records the applied and refused changes of an admin.
void SessionSupervisor::tell_of_changes() noexcept {
  Changes& changes = parts_.changes;
  while (const Changes::Done* done = changes.next(parts_.reconnector.sessions())) try {
      const bool taken = done->refusal.empty();
      // Update the law of the reconnector first. A new session with the wrong law is worse than a
      // missing message.
      if (taken && done->prepared.law) parts_.reconnector.put_law(changes.law());
      outlet_.say("an admin changes this session: " + done->what +
                  (taken ? std::string() : "; refused: " + done->refusal));
      parts_.records.note({{"what", done->what},
                           {"answer", taken ? "taken" : "refused"},
                           {"refusal", done->refusal}});
    } catch (const std::exception&) {  // no memory for the text
    }
}

/// Reports once why the client does not use the fetched data.
void SessionSupervisor::tell_of_fetch() noexcept {
  if (parts_.fetch.refusal() == fetch_refusal_) return;
  try {
    fetch_refusal_ = parts_.fetch.refusal();
    if (!fetch_refusal_.empty()) outlet_.say("warning: " + fetch_refusal_);
  } catch (const std::exception&) {  // no memory for the text
  }
}

}  // namespace feltwire
