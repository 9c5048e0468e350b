#pragma once

#include "server/web/page_hands.hpp"

namespace feltwire {

/// Page hands that are clients of this process. Defined by the room sim/page_hand, which may use
/// the server's and the client's rooms; a program that calls it links that room.
std::unique_ptr<web::PageHands> make_page_hands(const web::PageHandsSetup& setup);

}  // namespace feltwire
