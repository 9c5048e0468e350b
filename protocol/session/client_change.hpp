#pragma once
// The changes that a server may request from a client while its session runs: the law that bounds
// its force, and the link that it emulates. docs/admin.md says who may raise the force on a hand.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// The name of a bounding method as a plain value, so that a reply can hold it without allocating.
class MethodName {
 public:
  MethodName() = default;
  /// Precondition: at most kLongestMethodName bytes; the rest is cut off.
  explicit MethodName(std::string_view name) noexcept
      : size_(static_cast<std::uint8_t>(std::min(name.size(), text_.size()))) {
    std::copy_n(name.begin(), size_, text_.begin());
  }
  std::string_view view() const noexcept { return {text_.data(), size_}; }
  friend bool operator==(const MethodName&, const MethodName&) = default;

 private:
  std::array<char, kLongestMethodName> text_{};
  std::uint8_t size_ = 0;
};

/// The law at the client: those of its session parameters that can change while it runs.
struct LawChoice {
  MethodName mode;
  Projection projection = Projection::cone;
  Storage storage = Storage::minimal;
  friend bool operator==(const LawChoice&, const LawChoice&) = default;
};
LawChoice law_of(const SessionParameters& parameters);
/// The parameters with another law.
SessionParameters with_law(SessionParameters parameters, const LawChoice& law);

/// An emulated link, the same in both directions.
struct LinkQuality {
  static constexpr double kLongestDelay = 10.0;  // [s]
  double delay = 0.0;                            // [s] mean, one way; 0 to kLongestDelay
  double jitter = 0.0;                           // [s] standard deviation; 0 to kLongestDelay
  double loss = 0.0;                             // share of the datagrams, 0 to 1
  friend bool operator==(const LinkQuality&, const LinkQuality&) = default;
};
/// Written so that NaN fails. Never allocates.
inline bool possible(const LinkQuality& link) noexcept {
  const auto lies = [](double value, double most) { return value >= 0.0 && value <= most; };
  return lies(link.delay, LinkQuality::kLongestDelay) &&
         lies(link.jitter, LinkQuality::kLongestDelay) && lies(link.loss, 1.0);
}
/// The reason why there is no such link: the field, its range and the remedy. Empty if there is.
std::optional<std::string> wrong(const LinkQuality& link);

/// A change that travels in each reply until the client's reports acknowledge its number.
struct ClientChange {
  static constexpr std::uint8_t kLast = 63;  // the number after it is 1
  std::uint8_t number = 0;                   // 1 to kLast; identifies the change
  std::optional<LawChoice> law;              // empty: the law stays
  std::optional<LinkQuality> link;           // empty: the link stays
  friend bool operator==(const ClientChange&, const ClientChange&) = default;
};
constexpr std::uint8_t number_after(std::uint8_t number) {
  return number >= ClientChange::kLast ? std::uint8_t{1} : static_cast<std::uint8_t>(number + 1);
}

/// The laws that a client lets an admin choose. It says so when it joins, and judges each change by
/// itself: no server can take the bound off a hand.
enum class LawsTaken : std::uint8_t {
  none,  // its law never changes
  safe,  // the law at its start, and laws that are passive on their own for every hand and fault
  any    // every law that can take over while a session runs: no person's hand is at the device
};
inline constexpr std::array<std::string_view, 3> kLawsTakenNames = {"none", "safe", "any"};
std::string_view name(LawsTaken laws);

struct ChangesTaken {
  LawsTaken laws = LawsTaken::none;
  bool link = false;
  friend bool operator==(const ChangesTaken&, const ChangesTaken&) = default;
};

/// The client's answer to the newest requested change.
enum class ChangeAnswer : std::uint8_t { waiting, taken, refused };
inline constexpr std::array<std::string_view, 3> kChangeAnswerNames = {"waiting", "taken",
                                                                       "refused"};
std::string_view name(ChangeAnswer answer);

/// The changes at a client, for people who watch or change its session.
struct ClientChangeState {
  ChangesTaken takes{};  // changes that an admin may make at the client
  std::string asked{};  // the newest change requested of it: the old and the new value; empty: none
  ChangeAnswer answer = ChangeAnswer::waiting;  // the client's answer to that
};

/// The reason why a client that was started with these parameters does not take the law; empty if
/// it does. A law can take over if it and the previous one admit reductions, because the safety
/// stage and the account come after both.
std::optional<std::string> refuses_law(const SessionParameters& started, const LawChoice& law,
                                       LawsTaken taken);

/// For people: "mode shaped -> contact_frame, storage minimal -> elastic". Empty if they are equal.
std::string difference(const LawChoice& before, const LawChoice& after);
/// "link delay 25 ms, jitter 5 ms, loss 10 %".
std::string text(const LinkQuality& link);

}  // namespace feltwire
