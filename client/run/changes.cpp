#include "client/run/changes.hpp"

#include <stdexcept>
#include <utility>

#include "protocol/session/client_change.hpp"

namespace feltwire {

Changes::Changes(const Client& client)
    : spec_(client.spec),
      started_(client.started),
      now_(client.started),
      options_(client.options),
      port_(client.port),
      takes_(client.takes) {}

/// Returns the whole prepared change, or the reason for its refusal.
Changes::Done Changes::judged(const ClientChange& change) {
  Done done;
  done.prepared.number = change.number;
  const auto refuse = [&](std::string why) {
    done.refusal = std::move(why);
    done.prepared.refused = true;
    done.prepared.law.reset();
  };
  if (change.law) done.what = difference(law_of(now_), *change.law);
  if (change.link) done.what += (done.what.empty() ? "" : ", ") + text(*change.link);
  if (change.link) {
    if (!takes_.link)
      refuse("this client takes no other link: it was started without --changes");
    else if (auto no = port_.refuses_link(*change.link))
      refuse(*std::move(no));
    done.prepared.link = change.link;
  }
  if (!change.law || done.prepared.refused || *change.law == law_of(now_)) return done;
  if (auto no = refuses_law(started_, *change.law, takes_.laws)) {
    refuse(*std::move(no));
    return done;
  }
  try {
    SessionParameters next = with_law(now_, *change.law);
    done.prepared.law.emplace(spec_, next, options_);
    now_ = std::move(next);
  } catch (const std::invalid_argument& error) {  // the device does not support this law
    refuse(error.what());
  }
  return done;
}

/// Returns a refusal with the reason `why`. The list `done_` does not store it. The function
/// allocates no memory, because `why` fits into the string's own buffer.
Changes::Done& Changes::refused(const char* why) noexcept {
  Done& done = not_kept_[next_not_kept_];
  next_not_kept_ = (next_not_kept_ + 1) % not_kept_.size();
  done.prepared.refused = true;
  done.refusal = why;
  return done;
}

const Changes::Done* Changes::next(std::uint32_t session) noexcept {
  WantedChange wanted;
  do {
    if (!wanted_.pop(wanted)) return nullptr;
  } while (wanted.session != session);
  Done* done = nullptr;
  const std::size_t before = done_.size();
  if (before == kMost) {
    done = &refused("too many");
  } else {
    try {
      done_.emplace_back();
      done_.back() = judged(wanted.change);
      done = &done_.back();
    } catch (const std::exception&) {
      if (done_.size() > before) done_.pop_back();
      done = &refused("no memory");
    }
  }
  done->prepared.number = wanted.change.number;
  done->prepared.session = wanted.session;
  ready_.push(&done->prepared);
  return done;
}

}  // namespace feltwire
