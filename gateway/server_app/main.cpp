// feltwire-server: server/app/server_program.cpp, with hands for the live page. These hands are
// clients of this process, so that this file stands above the server and the client.

#include "gateway/page_hand/make_page_hands.hpp"
#include "server/app/server_program.hpp"

int main(int argc, char** argv) {
  return feltwire::server_program(argc, argv, feltwire::make_page_hands);
}
