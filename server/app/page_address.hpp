#pragma once

#include <string>

#include "server/access/security_options.hpp"

namespace feltwire {

/// "#token=fw_...", the token of this machine's user, for the address line of a browser, which
/// sends it nowhere (RFC 3986, 3.5). Empty where there is none, and where stdout is no terminal:
/// what is written to a file or a journal is read by others. Throws FileError.
std::string token_for_page(const SecurityOptions& config);

}  // namespace feltwire
