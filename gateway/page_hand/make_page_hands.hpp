#pragma once

#include "server/web/page_hands.hpp"

namespace feltwire {

/// Returns page hands that are clients of this process.
std::unique_ptr<web::PageHands> make_page_hands(const web::PageHandsSetup& setup);

}  // namespace feltwire
