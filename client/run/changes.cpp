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

/// All of it, or nothing.
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
      refuse("this client takes no other link: it was started with --fixed");
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
    const SessionParameters next = with_law(now_, *change.law);
    done.prepared.law.emplace(spec_, next, options_);
    now_ = next;
  } catch (const std::invalid_argument& error) {  // this device cannot have it
    refuse(error.what());
  }
  return done;
}

const Changes::Done* Changes::next() noexcept {
  ClientChange change;
  if (!wanted_.pop(change)) return nullptr;
  try {
    done_.push_back(judged(change));
  } catch (const std::exception&) {  // no memory: the server asks again, or its admin does
    return nullptr;
  }
  ready_.push(&done_.back().prepared);
  return &done_.back();
}

}  // namespace feltwire
