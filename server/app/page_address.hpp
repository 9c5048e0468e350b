#pragma once

#include <string>
#include <vector>

#include "server/access/security_options.hpp"
#include "server/web/web_server.hpp"

namespace feltwire {

/// "#token=fw_...", the token of this machine's user, for the address line of a browser, which does
/// not send it (RFC 3986, 3.5). Empty if there is none, or if stdout is not a terminal, because
/// others may read a file or a journal. Throws FileError.
std::string token_for_page(const SecurityOptions& config);
/// As token_for_page(), with the token of an admin. Also empty if that token is good no more.
std::string admin_token_for_page(const SecurityOptions& config);

/// The address of the page: `web` as in ServerConfig::web, and host names that browsers may use for
/// it. Throws the same as web_place().
web::WebOptions page_place(const std::string& web, const std::vector<std::string>& names);

/// The address at which this machine reaches a server that listens on `listens_on`.
std::string own_host(const std::string& listens_on);

}  // namespace feltwire
