#include "server/app/page_address.hpp"

#include <unistd.h>

#include <asio/ip/address.hpp>
#include <cctype>
#include <filesystem>

#include "core/base/json_document.hpp"
#include "server/access/admin_token.hpp"
#include "server/access/security.hpp"
#include "server/app/server_config.hpp"

namespace feltwire {

namespace {

/// Returns the token in the file. Empty if there is no such file, or if stdout is not a terminal.
std::string token_to_print(const std::filesystem::path& file) {
  if (::isatty(STDOUT_FILENO) == 0 || file.empty() || !std::filesystem::exists(file)) return {};
  std::string text = read_text(file);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0)
    text.pop_back();
  return text;
}

std::string fragment(const std::string& token) { return token.empty() ? "" : "#token=" + token; }

}  // namespace

std::string token_for_page(const SecurityOptions& config) {
  return fragment(token_to_print(local_token_file(config)));
}

std::string admin_token_for_page(const SecurityOptions& config) {
  const std::string token = token_to_print(admin_token_file(config));
  if (token.empty()) return {};
  const TokenFile tokens(token_file(config));
  const Token* good = authenticate(tokens.tokens(), token, calendar_now());
  return fragment(good != nullptr && covers(good->role, Role::admin) ? token : "");
}

web::WebOptions page_place(const std::string& web, const std::vector<std::string>& names) {
  const WebPlace place = web_place(web);
  web::WebOptions options;
  options.address = asio::ip::make_address(place.address);
  options.port = place.port;
  options.names = names;
  return options;
}

std::string own_host(const std::string& listens_on) {
  const auto address = asio::ip::make_address(listens_on);
  if (!address.is_unspecified()) return listens_on;
  return address.is_v6() ? "::1" : "127.0.0.1";
}

}  // namespace feltwire
