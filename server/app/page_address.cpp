#include "server/app/page_address.hpp"

#include <unistd.h>

#include <asio/ip/address.hpp>
#include <cctype>
#include <filesystem>

#include "core/base/json_document.hpp"
#include "server/access/security.hpp"
#include "server/app/config.hpp"

namespace feltwire {

std::string token_for_page(const SecurityOptions& config) {
  const auto token = local_token_file(config);
  if (::isatty(STDOUT_FILENO) == 0 || token.empty() || !std::filesystem::exists(token)) return {};
  std::string text = read_text(token);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0)
    text.pop_back();
  return "#token=" + text;
}

web::WebOptions page_place(const std::string& web, const std::vector<std::string>& names) {
  const WebPlace place = web_place(web);
  web::WebOptions options;
  options.address = asio::ip::make_address(place.address);
  options.port = place.port;
  options.names = names;
  return options;
}

}  // namespace feltwire
