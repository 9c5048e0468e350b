// Takes arbitrary text as an emulated link. The text must be refused with a reason, or the fates of
// datagrams must be possible.

#include <stdexcept>

#include "client/emulated_link/link_model.hpp"
#include "core/base/csv.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

void carry(const LinkOptions& options, std::uint64_t key) {
  constexpr int kDatagrams = 256;
  constexpr Nanoseconds kLongest = std::chrono::hours(24);  // a full queue at the lowest rate
  LinkModel model(options, key);
  Nanoseconds newest{0};
  for (int i = 0; i < kDatagrams; ++i) {
    const Nanoseconds now = std::chrono::microseconds(i * i);
    const LinkFate fate = model.next(static_cast<std::size_t>(i % 1200), now);
    require(fate.copies >= 0 && fate.copies <= 2, "none, one or two arrive");
    require((fate.loss == LinkFate::Loss::none) == (fate.copies > 0), "what is lost is lost");
    for (int copy = 0; copy < fate.copies; ++copy) {
      const Nanoseconds arrival = fate.arrivals[static_cast<std::size_t>(copy)];
      require(arrival >= now, "nothing arrives before it was sent");
      require(arrival - now < kLongest, "what arrives does so within reason");
    }
    if (fate.copies == 0 || !options.keep_order || options.reorder > 0.0) continue;
    require(fate.arrivals[0] >= newest, "none overtakes another");
    newest = fate.arrivals[0];
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string text = fuzz::text(data, size);
  // The text names a file (see link_trace.cpp).
  if (text.find("trace:") != std::string::npos) return 0;
  try {
    const TwoWayLinkOptions link = parse_link(text);
    validate(link.up);
    validate(link.down);
    fuzz::carry(link.up, link_key(link.seed, 0, LinkDirection::up));
    fuzz::carry(link.down, link_key(link.seed, 0, LinkDirection::down));
  } catch (const std::invalid_argument& error) {
    fuzz::require(std::string_view(error.what()).starts_with("link: "), "a refusal says of what");
  }
  return 0;
}
