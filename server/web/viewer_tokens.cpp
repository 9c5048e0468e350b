#include "server/web/viewer_tokens.hpp"

#include <spdlog/spdlog.h>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire::web {

void ViewerTokens::refresh() {
  if (const auto wrong = file_.refresh()) spdlog::error("{}", visible(*wrong));
}

const Token* ViewerTokens::authenticate(std::string_view text) const {
  return feltwire::authenticate(file_.tokens(), text, calendar_now());
}

bool ViewerTokens::may_try_again(const asio::ip::address& address) {
  return wrong_.take(address, monotonic_now());
}

}  // namespace feltwire::web
