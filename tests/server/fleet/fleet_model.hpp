#pragma once
// A small fleet around one scene, for an exhaustive search: three hosts, a client, and a directory
// that lies. Its steps call the functions that the product calls, through `Rules`, so that a test
// can break one of them.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocol/fleet/session_epoch.hpp"
#include "server/fleet/ownership.hpp"
#include "tests/server/fleet/write_history.hpp"

namespace feltwire::test {

/// The functions of the product; a mutant replaces one.
struct Rules {
  bool (*take_session)(SessionEpoch&, const Epoch&) = feltwire::take_session;
  bool (*hear_epoch)(SessionEpoch&, const Epoch&) = feltwire::hear_epoch;
  decltype(&feltwire::see_epoch) see_epoch = feltwire::see_epoch;
  decltype(&feltwire::see_record) see_record = feltwire::see_record;
  decltype(&feltwire::claim) claim = feltwire::claim;
  decltype(&feltwire::finish_claim) finish_claim = feltwire::finish_claim;
  decltype(&feltwire::take_over) take_over = feltwire::take_over;
  decltype(&feltwire::hand_over) hand_over = feltwire::hand_over;
  decltype(&feltwire::record_to_write) record_to_write = feltwire::record_to_write;
  decltype(&feltwire::answer_join) answer_join = feltwire::answer_join;
  bool numbers_differ = true;  // of processes at the same time
  bool number_is_new = true;   // of a process that starts again
};

/// How often each kind of step may happen on one path.
struct Bounds {
  std::size_t hosts = 3;  // that act
  int claims = 2, takeovers = 2, reservations = 2, writes = 3, losses = 1, restarts = 1, joins = 2;
  int handovers = 0;
};

class FleetModel {
 public:
  explicit FleetModel(const Rules& rules, const Bounds& bounds);

  /// Calls `visit` with a copy of this model after each possible step, and the step's name.
  void for_each_step(const Rules& rules,
                     const std::function<void(FleetModel&&, std::string)>& visit) const;
  /// The rule that the last step broke; empty: none.
  const std::string& violation() const { return violation_; }
  /// Lets the directory tell the truth, and everybody hear and write, until nothing changes. Says
  /// what is wrong then; empty: one host serves the scene, and the client is in.
  std::string settle(const Rules& rules) const;
  /// All that decides the further steps, as numbers.
  std::vector<std::uint64_t> key() const;

 private:
  struct Host {
    HostName self;
    SceneOwnership scene;
    bool sessions = false;  // it may have some
    /// A claim on its way: to the directory, or back with the revision of the answer.
    struct Claim {
      SceneRecord record;
      std::uint64_t expected = 0, revision = 0;
      bool answered = false;
    };
    std::optional<Claim> claim;
  };
  struct Join {
    std::size_t host = 0;
    Epoch client_highest;
  };
  struct Answer {
    Epoch epoch;
    bool accepted = false;
  };
  struct Acceptance {
    Epoch epoch;
    HostNumber process = 0;  // never used twice, unlike a mutant's host number
  };

  HostName new_process(std::size_t host, const Rules& rules);
  void break_rule(const std::string& rule);
  void check_host(Host& host);
  void check_former_owner(const Epoch& handed_over);
  void accept(std::size_t host, const Epoch& asked);
  void host_steps(std::size_t host, const Rules& rules,
                  const std::function<void(FleetModel&&, std::string)>& visit) const;
  void client_steps(const Rules& rules,
                    const std::function<void(FleetModel&&, std::string)>& visit) const;
  bool deliver_truth(const Rules& rules);
  bool write_truth(const Rules& rules);
  void claim_if_idle(const Rules& rules);
  bool client_joins(const Rules& rules);

  WriteHistory<SceneRecord> directory_;
  std::array<Host, 3> hosts_;
  std::array<std::uint64_t, 3> processes_{};  // the true numbers of the processes
  std::uint64_t started_ = 0;
  SessionEpoch client_;
  Epoch client_saw_;  // the highest, whatever the client remembers
  std::optional<Join> join_;
  std::optional<Answer> answer_;
  std::vector<Acceptance> accepted_;
  Bounds left_;
  std::string violation_;
};

}  // namespace feltwire::test
