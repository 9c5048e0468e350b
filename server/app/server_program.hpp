#pragma once
// The program feltwire-server, without what moves the hands of the live page.

#include "server/app/server.hpp"

namespace feltwire {

/// Serves scenes to haptic clients until SIGINT or SIGTERM. `make_page_hands`: as Server takes it.
/// Returns the exit code. Throws nothing.
int server_program(int argc, char** argv, const web::MakePageHands& make_page_hands);

}  // namespace feltwire
