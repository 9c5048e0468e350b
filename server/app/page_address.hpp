#pragma once

#include <string>
#include <vector>

#include "server/access/security_options.hpp"
#include "server/web/web_server.hpp"

namespace feltwire {

/// "#token=fw_...", the token of this machine's user, for the address line of a browser, which
/// sends it nowhere (RFC 3986, 3.5). Empty where there is none, and where stdout is no terminal:
/// what is written to a file or a journal is read by others. Throws FileError.
std::string token_for_page(const SecurityOptions& config);

/// Where the page is served: `web` as ServerConfig::web has it, and host names by which browsers
/// may ask for it. Throws std::invalid_argument where web_place() does.
web::WebOptions page_place(const std::string& web, const std::vector<std::string>& names);

}  // namespace feltwire
