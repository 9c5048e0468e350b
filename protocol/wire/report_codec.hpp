#pragma once
// Internal to the codec: a client's report about its hand, as values and as structs of the schema.

#include "protocol/wire/datagram_generated.h"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

/// Without its times.
wire::HandReport wire_report(const HandReport& report);
wire::HandTimes wire_times(const HandTimes& times);
/// `times`: null where none travelled.
HandReport value(const wire::HandReport& from, const wire::HandTimes* times);

}  // namespace feltwire
