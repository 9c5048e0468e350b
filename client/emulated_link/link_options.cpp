#include "client/emulated_link/link_options.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/base/enum_names.hpp"
#include "core/base/number_text.hpp"

namespace feltwire {
namespace {

struct Number {
  std::string_view key, unit, meaning;
  double least, most;  // smallest and largest value, in `unit`
  double scale;        // factor from `unit` to the unit of `member`
  double LinkOptions::*member;
};

constexpr double kMilliseconds = 1e-3, kPercent = 1e-2, kMegabits = 1e6, kKilobytes = 1e3;
constexpr double kLongestDelay = kLongestLinkDelay / kMilliseconds;

constexpr std::array kNumbers = {
    Number{"delay", "ms", "mean delay, one way", 0, kLongestDelay, kMilliseconds,
           &LinkOptions::delay},
    Number{"jitter", "ms", "standard deviation of the delay", 0, kLongestDelay, kMilliseconds,
           &LinkOptions::jitter},
    Number{"loss", "%", "share of lost datagrams", 0, 100, kPercent, &LinkOptions::loss},
    Number{"burst", "datagrams", "mean number of consecutive losses. Default: independent losses",
           1, 1e6, 1, &LinkOptions::burst},
    Number{"reorder", "%", "share of datagrams with the extra delay reorder_delay", 0, 100,
           kPercent, &LinkOptions::reorder},
    Number{"reorder_delay", "ms", "extra delay of the reordered datagrams. Default: 5", 0,
           kLongestDelay, kMilliseconds, &LinkOptions::reorder_delay},
    Number{"duplicate", "%", "share of datagrams that arrive twice", 0, 100, kPercent,
           &LinkOptions::duplicate},
    Number{"rate", "Mbit/s", "rate of the slowest line. Default: no limit", 1e-3, 1e5, kMegabits,
           &LinkOptions::rate},
    Number{"queue", "kB", "size of the queue before the slowest line. Default: 64", 2, 1e6,
           kKilobytes, &LinkOptions::queue},
};

/// Directions of the link that an item of the option text changes.
struct Directions {
  bool up = true, down = true;
};

[[noreturn]] void fail(const std::string& what) { throw std::invalid_argument("link: " + what); }

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string keys() {
  return joined_names(kNumbers, ", ", &Number::key) + ", distribution, order, seed";
}
std::string profile_names() { return joined_names(kLinkProfiles, ", ", &LinkProfile::name); }

/// Returns the number as text without trailing zeros.
std::string plain(double value) {
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
  return {text.data(), end};
}

template <class T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Applies `change` to the options of each chosen direction.
template <class Change>
void apply(TwoWayLinkOptions& link, Directions directions, Change change) {
  if (directions.up) change(link.up);
  if (directions.down) change(link.down);
}

void set_number(TwoWayLinkOptions& link, Directions directions, const Number& key,
                std::string_view text) {
  const std::optional<double> value = number<double>(text);
  if (!value && length_of_number(text) > 0) {
    const std::string meant = number_in_unit(text, key.unit);
    const std::string example = meant.empty() ? "" : ": " + std::string(key.key) + "=" + meant;
    fail(std::string(key.key) + "=" + std::string(text) +
         ": write the number without unit; it is in " + std::string(key.unit) + example);
  }
  if (!value || !(*value >= key.least && *value <= key.most))
    fail(std::string(key.key) + "=" + std::string(text) + " must be a number from " +
         plain(key.least) + " to " + plain(key.most) + " " + std::string(key.unit));
  apply(link, directions, [&](LinkOptions& one) { one.*key.member = *value * key.scale; });
}

void set_seed(TwoWayLinkOptions& link, Directions directions, std::string_view text) {
  if (!directions.up || !directions.down)
    fail("seed is one for both directions; write seed=" + std::string(text));
  const std::optional<std::uint64_t> seed = number<std::uint64_t>(text);
  if (!seed) fail("seed=" + std::string(text) + " must be a whole number from 0 to 2^64 - 1");
  link.seed = *seed;
}

void set_distribution(TwoWayLinkOptions& link, Directions directions, std::string_view text) {
  const auto* found = find_named(kJitterNames, text);
  if (found == nullptr)
    fail("distribution=" + std::string(text) + " is none; use " + joined_names(kJitterNames, ", "));
  apply(link, directions, [&](LinkOptions& one) {
    one.distribution = static_cast<Jitter>(found - kJitterNames.data());
  });
}

void set_order(TwoWayLinkOptions& link, Directions directions, std::string_view text) {
  if (text != "keep" && text != "free")
    fail("order=" + std::string(text) + " must be keep, or free to let jitter reorder");
  apply(link, directions, [&](LinkOptions& one) { one.keep_order = text == "keep"; });
}

void set(TwoWayLinkOptions& link, Directions directions, std::string_view key,
         std::string_view value) {
  if (key == "seed") return set_seed(link, directions, value);
  if (key == "distribution") return set_distribution(link, directions, value);
  if (key == "order") return set_order(link, directions, value);
  const Number* found = find_named(kNumbers, key, &Number::key);
  if (found == nullptr) fail("unknown key " + in_quotes(key) + "; keys are " + keys());
  set_number(link, directions, *found, value);
}

void read_items(TwoWayLinkOptions& link, std::string_view text);

void read_item(TwoWayLinkOptions& link, std::string_view item) {
  constexpr std::string_view kUp = "up.", kDown = "down.", kTrace = "trace:";
  std::string_view rest = item;
  const Directions directions{.up = !item.starts_with(kDown), .down = !item.starts_with(kUp)};
  if (!directions.down) rest.remove_prefix(kUp.size());
  if (!directions.up) rest.remove_prefix(kDown.size());

  if (rest.starts_with(kTrace)) {
    const auto trace =
        std::make_shared<const LinkTrace>(load_link_trace(rest.substr(kTrace.size())));
    return apply(link, directions, [&](LinkOptions& one) { one.trace = trace; });
  }
  const auto equals = rest.find('=');
  if (equals != std::string_view::npos)
    return set(link, directions, rest.substr(0, equals), rest.substr(equals + 1));

  const LinkProfile* profile = find_named(kLinkProfiles, rest, &LinkProfile::name);
  if (profile == nullptr)
    fail(in_quotes(item) + " is neither KEY=VALUE nor trace:FILE.csv nor a profile; profiles are " +
         profile_names() + ", keys are " + keys());
  TwoWayLinkOptions named;
  read_items(named, profile->items);
  if (directions.up) link.up = named.up;
  if (directions.down) link.down = named.down;
}

void read_items(TwoWayLinkOptions& link, std::string_view text) {
  while (true) {
    const auto comma = text.find(',');
    read_item(link, text.substr(0, comma));
    if (comma == std::string_view::npos) return;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

const std::array<LinkProfile, 7> kLinkProfiles = {{
    {"lan", "delay=0.15,jitter=0.03", "assumption: two switches of gigabit Ethernet"},
    {"wifi", "delay=2,jitter=2,distribution=pareto,loss=0.5,burst=3,rate=50",
     "assumption: a shared access point in a good place; retransmissions make the tail"},
    {"4g",
     "up.delay=25,down.delay=20,jitter=8,distribution=pareto,loss=0.3,burst=3,up.rate=10,"
     "down.rate=30",
     "assumption: LTE in a town, the server in the same country"},
    {"5g",
     "up.delay=8,down.delay=7,jitter=2,distribution=pareto,loss=0.1,burst=3,up.rate=50,"
     "down.rate=200",
     "assumption: public network below 6 GHz, the server in the same country"},
    {"transatlantic", "delay=38,jitter=0.5,loss=0.05",
     "London to New York, 5570 km at 2.04e5 km/s in fibre: 27 ms; times 1.4 for the cable's way, "
     "an assumption as the rest"},
    {"satellite", "delay=279,jitter=3,loss=0.5,burst=5,up.rate=5,down.rate=25",
     "delay: RFC 2488, geostationary, one hop at the edge of the beam; the rest assumption"},
    {"hostile", "delay=50,jitter=30,order=free,loss=20,burst=5,reorder=5,duplicate=5",
     "made up: worse than what a hand can work with, to see that it stays safe"},
}};

void validate(const LinkOptions& options) {
  if (options.trace && (options.delay > 0.0 || options.jitter > 0.0 || options.loss > 0.0))
    fail("trace:" + options.trace->file +
         " already says delay and loss; leave delay, jitter and loss out, or give them for the "
         "other direction only (up., down.)");
  // A larger loss would need a probability above 1 to enter the loss state (see link_model.cpp).
  if (options.burst > 0.0 && options.loss > options.burst / (options.burst + 1.0))
    fail("loss=" + plain(options.loss / kPercent) +
         " is too large for runs of burst=" + plain(options.burst) +
         " with a datagram between them; raise burst, or leave it out for independent losses");
}

TwoWayLinkOptions parse_link(std::string_view text) {
  TwoWayLinkOptions link;
  read_items(link, text);
  link.text = text;
  validate(link.up);
  validate(link.down);
  return link;
}

std::string link_help() {
  std::string text =
      "A link is a list of KEY=VALUE, profiles and trace:FILE.csv (columns t,delay,lost), "
      "separated "
      "by commas.\nup. or down. before an item limits the item to one direction. Later items "
      "override "
      "earlier ones.\n";
  const auto line = [&](std::string_view key, std::string_view meaning) {
    constexpr std::size_t kColumn = 24;
    text += "  " + std::string(key);
    text.append(kColumn - std::min(kColumn - 1, key.size()), ' ');
    text += std::string(meaning) + "\n";
  };
  for (const Number& n : kNumbers)
    line(std::string(n.key) + " [" + std::string(n.unit) + "]", n.meaning);
  line("distribution", "distribution of the jitter: normal, uniform or pareto");
  line("order", "keep: datagrams stay in order. free: jitter may reorder them");
  line("seed",
       "seed of the random numbers. The same seed gives the same losses and delays. Default: 1");
  text += "Profiles:\n";
  for (const LinkProfile& profile : kLinkProfiles) line(profile.name, profile.items);
  return text;
}

}  // namespace feltwire
