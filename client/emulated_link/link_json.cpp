#include "client/emulated_link/link_json.hpp"

#include "core/base/enum_names.hpp"

namespace feltwire {
namespace {

using Json = nlohmann::ordered_json;

Json direction(const OneWayLink& link) {
  const LinkOptions& o = link.options();
  const LinkStatistics s = link.statistics();
  const auto milliseconds = [&](double nanoseconds) {
    return s.delivered > 0 ? Json(1e-6 * nanoseconds) : Json(nullptr);
  };
  const auto count = [](Nanoseconds time) { return static_cast<double>(time.count()); };
  return {{"delay_ms", 1e3 * o.delay},
          {"jitter_ms", 1e3 * o.jitter},
          {"distribution", enum_name(kJitterNames, o.distribution)},
          {"order", o.keep_order ? "keep" : "free"},
          {"loss_percent", 1e2 * o.loss},
          {"burst", o.burst > 0.0 ? Json(o.burst) : Json(nullptr)},
          {"reorder_percent", 1e2 * o.reorder},
          {"reorder_delay_ms", 1e3 * o.reorder_delay},
          {"duplicate_percent", 1e2 * o.duplicate},
          {"rate_mbit_s", o.rate > 0.0 ? Json(1e-6 * o.rate) : Json(nullptr)},
          {"queue_kb", 1e-3 * o.queue},
          {"trace", o.trace ? Json(o.trace->file) : Json(nullptr)},
          {"entered", s.entered},
          {"delivered", s.delivered},
          {"lost", s.lost},
          {"queue_dropped", s.queue_dropped},
          {"overflowed", s.overflowed},
          {"duplicated", s.duplicated},
          {"reordered", s.reordered},
          {"in_flight", s.in_flight},
          {"measured_delay_ms",
           {{"min", milliseconds(count(s.least_delay))},
            {"mean", milliseconds(count(s.total_delay) /
                                  static_cast<double>(std::max<std::uint64_t>(s.delivered, 1)))},
            {"max", milliseconds(count(s.greatest_delay))}}}};
}

}  // namespace

Json link_json(const TwoWayLink& link) {
  return {{"given", link.text},
          {"seed", link.seed},
          {"up", direction(link.up)},
          {"down", direction(link.down)}};
}

}  // namespace feltwire
