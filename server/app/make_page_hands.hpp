#pragma once

#include "server/web/page_hands.hpp"

namespace feltwire {

/// Page hands that are clients of this process. The room gateway/page_hand defines it, because it
/// may use the server's and the client's rooms. A program that calls it links that room.
std::unique_ptr<web::PageHands> make_page_hands(const web::PageHandsSetup& setup);

}  // namespace feltwire
