#include "protocol/crypto/session_keys.hpp"

#include <sodium.h>

namespace feltwire {

SessionKeys::~SessionKeys() {
  sodium_memzero(up.data(), up.size());
  sodium_memzero(down.data(), down.size());
}

SessionKeys random_session_keys(CipherSuite suite) {
  SessionKeys keys{.suite = suite};
  randombytes_buf(keys.up.data(), keys.up.size());
  randombytes_buf(keys.down.data(), keys.down.size());
  return keys;
}

}  // namespace feltwire
