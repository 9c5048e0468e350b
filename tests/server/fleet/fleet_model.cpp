#include "tests/server/fleet/fleet_model.hpp"

#include <algorithm>
#include <utility>

namespace feltwire::test {
namespace {

const std::string kScene = "room";
constexpr std::array<const char*, 3> kNames = {"A", "B", "C"};

class Numbers {
 public:
  void add(std::uint64_t number) { numbers_.push_back(number); }
  void add(const Epoch& epoch) {
    add(epoch.term);
    add(epoch.holder);
  }
  void add(const RecordVersion& version) {
    add(version.epoch);
    add(version.change);
  }
  void add(const SceneRecord& record) {
    add(record.version);
    add(record.standby.number);
    add(record.handed_over ? 1 : 0);
  }
  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value() ? 1 : 0);
    if (value) add(*value);
  }
  std::vector<std::uint64_t> take() { return std::move(numbers_); }

 private:
  std::vector<std::uint64_t> numbers_;
};

}  // namespace

FleetModel::FleetModel(const Rules& rules, const Bounds& bounds) : left_(bounds) {
  for (std::size_t host = 0; host < hosts_.size(); ++host)
    hosts_[host].self = new_process(host, rules);
}

HostName FleetModel::new_process(std::size_t host, const Rules& rules) {
  const std::uint64_t process = ++started_;
  const bool first = processes_[host] == 0;
  processes_[host] = process;
  if (!rules.numbers_differ) return {kNames[host], 1};
  return {kNames[host], first || rules.number_is_new ? process : hosts_[host].self.number};
}

void FleetModel::break_rule(const std::string& rule) {
  if (violation_.empty()) violation_ = rule;
}

void FleetModel::check_host(Host& host) {
  if (host.scene.serving) host.sessions = true;
  if (host.scene.serving && *host.scene.serving < host.scene.highest)
    break_rule("a host serves below an epoch that it has seen");
}

void FleetModel::check_former_owner(const Epoch& handed_over) {
  for (const Host& host : hosts_)
    if (host.scene.serving == handed_over)
      break_rule("a former owner takes joins beside the host that has the scene from it");
}

void FleetModel::accept(std::size_t host, const Epoch& asked) {
  const Epoch epoch = *hosts_[host].scene.serving;
  if (epoch < asked) break_rule("a host accepts a client that has seen a higher epoch");
  for (const Acceptance& other : accepted_)
    if (other.epoch == epoch && other.process != processes_[host])
      break_rule("two processes accept at one epoch");
  const bool known =
      std::ranges::any_of(accepted_, [&](const Acceptance& other) { return other.epoch == epoch; });
  if (!known) accepted_.push_back({epoch, processes_[host]});
  answer_ = {epoch, true};
}

void FleetModel::for_each_step(const Rules& rules,
                               const std::function<void(FleetModel&&, std::string)>& visit) const {
  if (left_.losses > 0) {
    for (std::size_t lost = 1; lost <= directory_.log().size(); ++lost) {
      FleetModel next = *this;
      --next.left_.losses;
      next.directory_.lose(lost);
      visit(std::move(next), "the directory loses " + std::to_string(lost));
    }
  }
  for (std::size_t host = 0; host < left_.hosts; ++host) host_steps(host, rules, visit);
  client_steps(rules, visit);
}

void FleetModel::host_steps(std::size_t at, const Rules& rules,
                            const std::function<void(FleetModel&&, std::string)>& visit) const {
  const Host& now = hosts_[at];
  const std::string name = kNames[at];
  const auto step = [&](const std::string& what, const auto& change) {
    FleetModel next = *this;
    change(next, next.hosts_[at]);
    next.check_host(next.hosts_[at]);
    visit(std::move(next), name + " " + what);
  };
  // Stale, late, twice and out of order: any write that ever was.
  for (std::size_t i = 0; i < directory_.ever().size(); ++i) {
    step("sees write " + std::to_string(i + 1), [&](FleetModel&, Host& host) {
      const auto& write = directory_.ever()[i];
      if (rules.see_record(host.scene, write.value, write.revision)) host.sessions = false;
    });
  }
  if (left_.claims > 0 && !now.scene.serving && !now.claim) {
    step("sends a claim", [&](FleetModel& next, Host& host) {
      --next.left_.claims;
      const std::uint64_t expected = host.scene.revision;
      host.claim = Host::Claim{rules.claim(host.scene, host.self, {}), expected, 0, false};
    });
  }
  if (now.claim && !now.claim->answered) {
    step("has its claim written, or not", [&](FleetModel& next, Host& host) {
      const auto answer =
          next.directory_.compare_and_swap(kScene, host.claim->record, host.claim->expected);
      host.claim->answered = true;
      host.claim->revision = answer.revision;
      if (answer.result != WriteResult::written) host.claim.reset();
    });
  }
  if (now.claim && now.claim->answered) {
    step("gets the answer to its claim", [&](FleetModel&, Host& host) {
      rules.finish_claim(host.scene, host.claim->record, host.claim->revision);
      host.claim.reset();
    });
  }
  if (now.claim) step("gets no answer", [](FleetModel&, Host& host) { host.claim.reset(); });
  if (left_.takeovers > 0 && !now.claim) {
    step("takes over", [&](FleetModel& next, Host& host) {
      if (rules.take_over(host.scene, host.self)) --next.left_.takeovers;
    });
  }
  if (is_handed_to(now.scene, now.self)) {
    step("takes what was handed over", [&](FleetModel& next, Host& host) {
      const Epoch former = host.scene.record.version.epoch;
      if (rules.take_over(host.scene, host.self)) next.check_former_owner(former);
    });
  }
  if (left_.handovers > 0 && now.scene.serving) {
    for (std::size_t other = 0; other < left_.hosts; ++other) {
      if (other == at) continue;
      step(std::string("hands over to ") + kNames[other], [&](FleetModel& next, Host& host) {
        --next.left_.handovers;
        rules.hand_over(host.scene, hosts_[other].self);
      });
    }
  }
  if (left_.reservations > 0 && now.scene.serving) {
    for (std::size_t other = 0; other < left_.hosts; ++other) {
      if (other == at) continue;
      step(std::string("names ") + kNames[other] + " its standby",
           [&](FleetModel& next, Host& host) {
             --next.left_.reservations;
             reserve_standby(host.scene, hosts_[other].self);
           });
    }
  }
  if (left_.writes > 0 && rules.record_to_write(now.scene)) {
    step("writes its record", [&](FleetModel& next, Host& host) {
      --next.left_.writes;
      next.directory_.compare_and_swap(kScene, *rules.record_to_write(host.scene),
                                       host.scene.revision);
    });
  }
  if (left_.restarts > 0) {
    step("starts again", [&](FleetModel& next, Host& host) {
      --next.left_.restarts;
      const HostName self = next.new_process(at, rules);
      host = Host{self, {}, false, {}};
    });
  }
}

void FleetModel::client_steps(const Rules& rules,
                              const std::function<void(FleetModel&&, std::string)>& visit) const {
  const auto step = [&](const std::string& what, const auto& change) {
    FleetModel next = *this;
    change(next);
    for (Host& host : next.hosts_) next.check_host(host);
    if (next.client_.session && *next.client_.session < next.client_saw_)
      next.break_rule("the client has a session below an epoch that it has seen");
    visit(std::move(next), "the client " + what);
  };
  for (std::size_t host = 0; host < left_.hosts; ++host) {
    const std::string name = kNames[host];
    const Epoch& announced = hosts_[host].scene.record.version.epoch;
    if (announced.holder != 0) {
      step("hears from " + name + " who owns the scene", [&](FleetModel& next) {
        next.client_saw_ = std::max(next.client_saw_, announced);
        rules.hear_epoch(next.client_, announced);
      });
    }
    if (client_.highest > hosts_[host].scene.highest) {
      step("shows " + name + " a ticket of a later owner", [&](FleetModel& next) {
        Host& shown = next.hosts_[host];
        if (rules.see_epoch(shown.scene, client_.highest)) shown.sessions = false;
      });
    }
    if (left_.joins > 0 && !join_ && !answer_) {
      step("asks " + name + " to join", [&](FleetModel& next) {
        --next.left_.joins;
        next.join_ = Join{host, client_.highest};
      });
    }
  }
  if (join_) {
    step(std::string("has its join answered by ") + kNames[join_->host], [&](FleetModel& next) {
      const SceneOwnership& scene = hosts_[join_->host].scene;
      switch (rules.answer_join(scene, join_->client_highest)) {
        case JoinAnswer::accepted:
          next.accept(join_->host, join_->client_highest);
          break;
        case JoinAnswer::redirected:
          next.answer_ = Answer{scene.record.version.epoch, false};
          break;
        case JoinAnswer::unknown:
          break;
      }
      next.join_.reset();
    });
  }
  if (answer_) {
    step("gets the answer to its join", [&](FleetModel& next) {
      next.client_saw_ = std::max(next.client_saw_, answer_->epoch);
      if (answer_->accepted)
        rules.take_session(next.client_, answer_->epoch);
      else
        rules.hear_epoch(next.client_, answer_->epoch);
      next.answer_.reset();
    });
  }
}

bool FleetModel::deliver_truth(const Rules& rules) {
  const auto* const current = directory_.current(kScene);
  bool changed = false;
  for (Host& host : hosts_) {
    const SceneOwnership before = host.scene;
    if (current != nullptr) {
      if (rules.see_record(host.scene, current->value, current->revision)) host.sessions = false;
    } else {
      host.scene.revision = 0;  // a list says that there is no such key
      host.scene.stored = {};
    }
    changed = changed || host.scene != before;
  }
  return changed;
}

bool FleetModel::write_truth(const Rules& rules) {
  bool written = false;
  for (Host& host : hosts_) {
    if (is_handed_to(host.scene, host.self)) rules.take_over(host.scene, host.self);
    const auto record = rules.record_to_write(host.scene);
    if (!record) continue;
    const auto answer = directory_.compare_and_swap(kScene, *record, host.scene.revision);
    written = written || answer.result == WriteResult::written;
  }
  return written;
}

void FleetModel::claim_if_idle(const Rules& rules) {
  for (const Host& host : hosts_)
    if (host.scene.serving) return;
  Host& host = hosts_[0];
  const SceneRecord record = rules.claim(host.scene, host.self, {});
  const auto answer = directory_.compare_and_swap(kScene, record, host.scene.revision);
  if (answer.result == WriteResult::written)
    rules.finish_claim(host.scene, record, answer.revision);
}

bool FleetModel::client_joins(const Rules& rules) {
  for (const Host& host : hosts_)
    if (rules.answer_join(host.scene, client_.highest) == JoinAnswer::accepted)
      return rules.take_session(client_, *host.scene.serving);
  for (Host& host : hosts_)  // it shows its ticket
    if (rules.see_epoch(host.scene, client_.highest)) host.sessions = false;
  return false;
}

std::string FleetModel::settle(const Rules& rules) const {
  FleetModel calm = *this;
  constexpr int kMostRounds = 12;
  for (Host& host : calm.hosts_) host.claim.reset();
  bool joined = false;
  for (int round = 0; round < kMostRounds && !joined; ++round) {
    bool changed = true;
    for (int i = 0; i < kMostRounds && changed; ++i) {
      changed = calm.deliver_truth(rules);
      changed = calm.write_truth(rules) || changed;
    }
    if (changed) return "the hosts write without an end";
    calm.claim_if_idle(rules);
    calm.deliver_truth(rules);
    joined = calm.client_joins(rules);
  }
  const auto serving = std::ranges::count_if(
      calm.hosts_, [](const Host& host) { return host.scene.serving.has_value(); });
  if (serving != 1) return std::to_string(serving) + " hosts serve the scene for ever";
  for (const Host& host : calm.hosts_)
    if (host.sessions && !host.scene.serving) return "sessions of a former owner go on for ever";
  return joined ? "" : "the client stays outside";
}

std::vector<std::uint64_t> FleetModel::key() const {
  Numbers numbers;
  for (const auto& write : directory_.log()) numbers.add(write.value);
  numbers.add(directory_.log().size());
  for (const auto& write : directory_.ever()) {
    numbers.add(write.value);
    numbers.add(write.revision);
  }
  numbers.add(directory_.ever().size());
  for (const Host& host : hosts_) {
    numbers.add(host.self.number);
    numbers.add(host.scene.highest);
    numbers.add(host.scene.serving);
    numbers.add(host.scene.leaving);
    numbers.add(host.sessions ? 1 : 0);
    numbers.add(host.scene.record);
    numbers.add(host.scene.stored);
    numbers.add(host.scene.revision);
    numbers.add(host.scene.last_term);
    numbers.add(host.scene.changes);
    numbers.add(host.claim.has_value() ? 1 : 0);
    if (!host.claim) continue;
    numbers.add(host.claim->record);
    numbers.add(host.claim->expected);
    numbers.add(host.claim->revision);
    numbers.add(host.claim->answered ? 1 : 0);
  }
  for (const std::uint64_t process : processes_) numbers.add(process);
  numbers.add(client_.highest);
  numbers.add(client_.session);
  numbers.add(client_saw_);
  numbers.add(join_ ? 1 + join_->host : 0);
  if (join_) numbers.add(join_->client_highest);
  numbers.add(answer_ ? 1 + (answer_->accepted ? 1 : 0) : 0);
  if (answer_) numbers.add(answer_->epoch);
  for (const Acceptance& acceptance : accepted_) {
    numbers.add(acceptance.epoch);
    numbers.add(acceptance.process);
  }
  for (const int left : {left_.claims, left_.takeovers, left_.reservations, left_.writes,
                         left_.losses, left_.restarts, left_.joins, left_.handovers})
    numbers.add(static_cast<std::uint64_t>(left));
  return numbers.take();
}

}  // namespace feltwire::test
