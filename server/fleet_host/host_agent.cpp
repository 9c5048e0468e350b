#include "server/fleet_host/host_agent.hpp"

#include <spdlog/spdlog.h>

#include <asio/ip/address.hpp>
#include <map>
#include <random>
#include <system_error>
#include <utility>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "server/fleet/record_codec.hpp"
#include "server/fleet_host/key_file.hpp"
#include "server/fleet_host/server_answers.hpp"

namespace feltwire {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kBetweenLooks = 20ms, kWatchPatience = 1ms;
constexpr Nanoseconds kBetweenLists = 30s;  // a watch may miss a change
constexpr Nanoseconds kDeaf = 2 * kBeat;    // of a watch that does not deliver our own heartbeats
static_assert(kDeaf < kSilent, "the others would be taken for silent");
constexpr Nanoseconds kWriteAgain = 1s;  // after a write without an answer
constexpr Nanoseconds kSaveAgain = 10s;  // after a file that could not be written
constexpr Nanoseconds kKeyLife = 24h;    // of the key that signs
constexpr Nanoseconds kAnnounced = 60s;  // until all hosts know the next key
constexpr std::chrono::milliseconds kProbe{500};
constexpr int kProbes = 2;  // without an answer: the host is gone
constexpr std::array kBuckets = {Bucket::scenes, Bucket::hosts, Bucket::wishes, Bucket::tokens};
static_assert(kBuckets.size() == kBucketCount);

bool answers(const FleetMember::Suspect& suspect) {
  if (suspect.port == 0) return false;
  std::error_code wrong;
  const auto address = asio::ip::make_address(suspect.address, wrong);
  if (wrong) return false;
  for (int i = 0; i < kProbes; ++i)
    if (!silence_of({address, suspect.port}, kProbe, suspect.fingerprint)) return true;
  return false;
}

}  // namespace

HostAgent::HostAgent(std::shared_ptr<Directory> directory, FleetMember& member,
                     AgentCallbacks callbacks, const AgentFiles& files)
    : directory_(std::move(directory)),
      member_(member),
      callbacks_(std::move(callbacks)),
      keys_(files.keys),
      tokens_(files.tokens.empty() ? nullptr : std::make_unique<FleetTokens>(files.tokens)) {}

HostAgent::~HostAgent() { stop(); }

void HostAgent::start() {
  watch(monotonic_now());
  next_key_ = monotonic_now() + kKeyLife;
  thread_ = std::thread([this] { run(); });
}

void HostAgent::watch(Nanoseconds now) {
  for (const Bucket bucket : kBuckets)
    watches_[static_cast<std::size_t>(bucket)] = directory_->watch(bucket);
  delivered_ = now;
}

void HostAgent::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void HostAgent::drain(Nanoseconds patience) {
  member_.drain(true);
  std::unique_lock lock(mutex_);
  ends_ = true;
  woken_.wait_for(lock, patience, [this] { return drained_ || stop_; });
}

bool HostAgent::ended() {
  std::unique_lock lock(mutex_);
  return woken_.wait_for(lock, kBetweenLooks, [this] { return stop_; });
}

void HostAgent::run() {
  while (!ended()) try {
      look(monotonic_now());
    } catch (const std::exception& error) {
      spdlog::error("fleet: {}; it goes on", visible(error.what()));
    }
}

/// Does one round. A call of the directory may wait for its patience, so suspects are asked between
/// the calls: a takeover waits for one call at most.
void HostAgent::look(Nanoseconds now) {
  ask_suspects();
  read(Bucket::hosts);
  read(Bucket::scenes);
  if (auto lost = member_.take_lost(); !lost.empty()) {
    for (const std::string& scene : lost)
      spdlog::warn("fleet: another host serves scene {} now", visible(scene));
    callbacks_.lost(std::move(lost));
  }
  read(Bucket::tokens);
  save_tokens(now);
  read(Bucket::wishes);
  for (const std::string& scene : member_.take_handed())
    spdlog::info("fleet: this host serves scene {} from now on; its owner has handed it over",
                 visible(scene));
  ask_suspects();
  hand_over();
  if (member_.take_news() || now >= next_beat_) beat(now);
  ask_suspects();
  if (now >= next_list_) list(now);
  if (now >= next_write_) write(now);
  if (now >= next_key_ && !keys_.empty()) change_keys(now);
  const std::lock_guard lock(mutex_);
  drained_ = ends_ && member_.drained();
  if (drained_) woken_.notify_all();
}

/// Hands scenes over to hosts that answer. The record that says so is written directly after.
void HostAgent::hand_over() {
  static thread_local std::random_device random;
  std::map<HostNumber, bool> there;
  for (const FleetMember::HandOver& next : member_.hand_overs(monotonic_now(), random())) {
    const HostName& target = next.target.host;
    if (!there.contains(target.number)) there[target.number] = answers(next.target);
    if (member_.hand_over(next, there[target.number], monotonic_now()))
      spdlog::info("fleet: scene {} goes to host {}", visible(next.scene), visible(target.name));
  }
}

void HostAgent::beat(Nanoseconds now) {
  next_beat_ = now + kBeat;
  const HostRecord record = member_.heartbeat(callbacks_.load());
  const WriteAnswer answer = directory_->put(Bucket::hosts, record.host.name, encode(record));
  const bool silent = answer.result != WriteResult::written;
  if (!silent) {
    member_.heard(monotonic_now());
    // A server that held the directory's end of the watches may have died, and another one answers.
    if (now - delivered_ > kDeaf) watch(now);
  }
  if (std::exchange(kept_, record.kept) != record.kept && !record.kept.empty())
    spdlog::warn("fleet: this host drains and keeps {}", visible(record.kept));
  if (std::exchange(silent_, silent) == silent) return;
  if (silent) {
    spdlog::warn("fleet: the directory does not answer; sessions, joins and takeovers go on");
  } else {
    spdlog::info("fleet: the directory answers again");
  }
}

void HostAgent::read(Bucket bucket) {
  constexpr int kMost = 10'000;  // in one round
  DirectoryWatch& watch = *watches_[static_cast<std::size_t>(bucket)];
  for (int i = 0; i < kMost; ++i) {
    const auto entry = watch.next(kWatchPatience);
    if (!entry) return;
    if (bucket == Bucket::hosts) delivered_ = monotonic_now();
    see(bucket, *entry);
  }
}

void HostAgent::see(Bucket bucket, const DirectoryEntry& entry) {
  if (bucket == Bucket::tokens) {
    if (tokens_ != nullptr) tokens_->see(entry);
  } else {
    member_.see(bucket, entry, monotonic_now());
  }
}

void HostAgent::list(Nanoseconds now) {
  next_list_ = now + kBeat;  // if there is no answer
  const auto scenes = directory_->list(Bucket::scenes);
  if (!scenes) return;
  const auto hosts = directory_->list(Bucket::hosts);
  if (!hosts) return;
  see_all(Bucket::scenes, *scenes);
  see_all(Bucket::hosts, *hosts);
  member_.listed();
  next_list_ = now + kBetweenLists;
  ask_suspects();
  if (const auto wishes = directory_->list(Bucket::wishes)) see_all(Bucket::wishes, *wishes);
  if (tokens_ == nullptr) return;
  ask_suspects();
  const auto tokens = directory_->list(Bucket::tokens);
  if (!tokens) return;
  see_all(Bucket::tokens, *tokens);
  write_tokens(*tokens);
}

void HostAgent::see_all(Bucket bucket, const std::vector<DirectoryEntry>& entries) {
  for (const DirectoryEntry& entry : entries) see(bucket, entry);
}

/// Gives the directory the tokens, and the revocations, that it has lost.
void HostAgent::write_tokens(const std::vector<DirectoryEntry>& listed) {
  for (const FleetTokens::Write& write : tokens_->missing(listed)) {
    const WriteAnswer answer =
        directory_->compare_and_swap(Bucket::tokens, write.key, write.value, write.revision);
    ask_suspects();
    if (answer.result == WriteResult::unknown) return;  // the next list shows what it has
  }
}

void HostAgent::save_tokens(Nanoseconds now) {
  if (tokens_ == nullptr || !tokens_->changed() || now < next_save_) return;
  next_save_ = now + kSaveAgain;  // if it fails
  tokens_->save();
  next_save_ = Nanoseconds(0);
  callbacks_.tokens();
}

void HostAgent::write(Nanoseconds now) {
  static thread_local std::random_device random;
  for (const FleetMember::Write& write : member_.writes(now, random())) {
    const WriteAnswer answer = directory_->compare_and_swap(Bucket::scenes, write.scene,
                                                            encode(write.record), write.revision);
    member_.finish(write, answer);
    ask_suspects();
    if (answer.result == WriteResult::unknown) {
      next_write_ = monotonic_now() + kWriteAgain;
      return;
    }
    if (answer.result == WriteResult::conflict) {
      next_list_ = Nanoseconds(0);  // learn what the directory has
      continue;
    }
    if (write.claims)
      spdlog::info("fleet: this host serves scene {} from now on, in term {}", visible(write.scene),
                   write.record.version.epoch.term);
  }
}

void HostAgent::ask_suspects() {
  while (const auto suspect = member_.suspect(monotonic_now())) {
    const bool alive = answers(*suspect);
    if (!alive) spdlog::warn("fleet: host {} gives no answer", visible(suspect->host.name));
    for (const std::string& scene : member_.probed(suspect->host, alive))
      spdlog::info("fleet: this host has taken over scene {}", visible(scene));
  }
}

/// Announces the next key, and lets it sign when every host knows it.
void HostAgent::change_keys(Nanoseconds now) {
  std::vector<paseto::SigningKey> keys = ticket_keys(keys_);
  if (!std::exchange(announced_, true)) {
    keys.resize(1, keys.front());
    keys.push_back(paseto::SigningKey::random());
    write_ticket_keys(keys_, keys);
    member_.announce(keys.back());
    next_key_ = now + kAnnounced;
    return;
  }
  std::swap(keys.front(), keys.back());
  write_ticket_keys(keys_, keys);
  member_.change_key();
  announced_ = false;
  next_key_ = now + kKeyLife;
  spdlog::info("fleet: tickets are signed with the next key");
}

}  // namespace feltwire
