#include "protocol/crypto/secret.hpp"

#include <sodium.h>
#include <sys/prctl.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>

namespace feltwire {

Secret::~Secret() { sodium_memzero(bytes_.data(), bytes_.size()); }

void wipe(std::string& text) noexcept {
  sodium_memzero(text.data(), text.size());
  text.clear();
}

void wipe(std::vector<std::uint8_t>& bytes) noexcept {
  sodium_memzero(bytes.data(), bytes.size());
  bytes.clear();
}

void end_without_random_numbers() noexcept {
  sodium_set_misuse_handler([] {
    std::fprintf(stderr, "%s: the system has no source of random numbers (getrandom)\n",
                 program_invocation_short_name);
    std::_Exit(1);
  });
}

void forbid_core_dumps() noexcept { ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0); }

}  // namespace feltwire
