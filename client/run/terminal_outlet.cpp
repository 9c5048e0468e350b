#include "client/run/terminal_outlet.hpp"

#include <cstdio>
#include <exception>
#include <string>

#include "core/base/visible_text.hpp"

namespace feltwire {

void TerminalOutlet::say(std::string_view line) noexcept {
  line_.end();
  try {
    std::fprintf(stderr, "feltwire-client: %s\n", visible(line).c_str());
  } catch (const std::exception&) {  // no memory for the line
  }
}

void TerminalOutlet::show(const LiveStatus& status, std::string_view more) noexcept {
  try {
    line_.show(status, more);
  } catch (const std::exception&) {  // no memory for this status
  }
}

}  // namespace feltwire
