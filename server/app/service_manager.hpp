#pragma once

#include <string_view>

namespace feltwire {

/// Tells systemd the state of this service, "READY=1" or "STOPPING=1" (sd_notify(3)). Does nothing
/// without NOTIFY_SOCKET in the environment, or if nobody listens there.
void tell_service_manager(std::string_view state) noexcept;

}  // namespace feltwire
