// feltwire-view: serves the live page of scenes that another server computes.

#include <csignal>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "gateway/app/gateway.hpp"
#include "gateway/app/gateway_options.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/crypto/secret.hpp"
#include "server/access/security.hpp"
#include "server/app/log_format.hpp"
#include "server/app/page_address.hpp"
#include "server/app/signals.hpp"

namespace {

constexpr int kBadUsage = 2, kCannotRun = 1;

int fail(int status, const char* what) {
  std::fprintf(stderr, "feltwire-view: %s\n", feltwire::printable_error(what).c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  feltwire::forbid_core_dumps();
  feltwire::end_without_random_numbers();
  try {
    const feltwire::GatewayConfig config = feltwire::gateway_config(argc, argv);
    feltwire::open_log("feltwire-view", config.log_level, config.log_format);
    // Block signals before any thread starts, so that only this thread receives them.
    const sigset_t signals = feltwire::block_signals();
    std::signal(SIGPIPE, SIG_IGN);

    feltwire::Gateway gateway(config);
    std::printf("live page: %s%s\n", gateway.web_url().c_str(),
                feltwire::token_for_page(config).c_str());
    std::fflush(stdout);
    feltwire::wait_for_end(signals, {[] {}, [&] { gateway.reload(); }});
    gateway.stop();
    return 0;
  } catch (const std::invalid_argument& error) {
    return fail(kBadUsage, error.what());
  } catch (const std::exception& error) {
    return fail(kCannotRun, error.what());
  }
}
