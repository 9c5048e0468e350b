#include "protocol/session/client_change.hpp"

#include <cstdio>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

std::string digits(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

/// Returns an error text if the value is outside [0, most] or is NaN.
std::optional<std::string> out_of_range(const char* field, double value, double most,
                                        const char* range) {
  if (value >= 0.0 && value <= most) return std::nullopt;
  return std::string(field) + " must be " + range;
}

/// Returns true if the method is passive for every hand and under all faults.
bool passive_by_itself(const BoundingMethod& method) {
  return promise(method, kAllFaults) == Promise::port;
}

}  // namespace

LawChoice law_of(const SessionParameters& parameters) {
  return {MethodName(parameters.mode), parameters.projection, parameters.storage};
}

SessionParameters with_law(SessionParameters parameters, const LawChoice& law) {
  parameters.mode = law.mode.view();
  parameters.projection = law.projection;
  parameters.storage = law.storage;
  return parameters;
}

std::optional<std::string> wrong(const LinkQuality& link) {
  if (auto no = out_of_range("link delay", link.delay, LinkQuality::kLongestDelay,
                             "from 0 to 10 s; give less"))
    return no;
  if (auto no = out_of_range("link jitter", link.jitter, LinkQuality::kLongestDelay,
                             "from 0 to 10 s; give less"))
    return no;
  return out_of_range("link loss", link.loss, 1.0, "a share from 0 to 1; give less");
}

std::string_view name(LawsTaken laws) { return enum_name(kLawsTakenNames, laws); }

std::string_view name(ChangeAnswer answer) { return enum_name(kChangeAnswerNames, answer); }

std::optional<std::string> refuses_law(const SessionParameters& started, const LawChoice& law,
                                       LawsTaken taken) {
  if (started.side != BoundingSide::client)
    return "the bound of this session does not run at the client alone: have it leave and join "
           "again with other options";
  if (taken == LawsTaken::none)
    return "its client takes no other law: its owner did not allow it; start it anew with "
           "--changes "
           "safe, or with the --mode that you want";
  const SessionParameters wanted = with_law(started, law);
  try {
    validate(wanted);
    const BoundingMethod& next = bounding_method(wanted.mode);
    if (!next.admits_reduction || !bounding_method(started.mode).admits_reduction)
      return "the mode " + visible(next.admits_reduction ? started.mode : wanted.mode) +
             " bounds forces from below, so no other law can take over from it or give way to it "
             "while a session runs: have the client leave and join again with --mode";
    if (taken == LawsTaken::safe && law != law_of(started) && !passive_by_itself(next))
      return "a person's hand may be at this device, so its client takes only the law that it was "
             "started with, contact_frame and others that are passive by themselves; start it anew "
             "with --mode " +
             visible(wanted.mode);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return std::nullopt;
}

std::string difference(const LawChoice& before, const LawChoice& after) {
  std::string all;
  const auto compare = [&](const char* field, std::string_view a, std::string_view b) {
    if (a == b) return;
    all += (all.empty() ? "" : ", ") + std::string(field) + " " + visible(std::string(a)) + " -> " +
           visible(std::string(b));
  };
  compare("mode", before.mode.view(), after.mode.view());
  compare("projection", name(before.projection), name(after.projection));
  compare("storage", name(before.storage), name(after.storage));
  return all;
}

std::string text(const LinkQuality& link) {
  return "link delay " + digits(kMilli * link.delay) + " ms, jitter " +
         digits(kMilli * link.jitter) + " ms, loss " + digits(kPercent * link.loss) + " %";
}

}  // namespace feltwire
