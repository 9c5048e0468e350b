#include "protocol/wire/session_secrets.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

namespace feltwire {
namespace {

Secret secret_of(const Key& key) {
  return Secret({reinterpret_cast<const char*>(key.data()), key.size()});
}

void copy_key(const char* field, const Secret& secret, Key& key) {
  const std::string_view bytes = secret.text();
  if (bytes.size() != key.size())
    throw std::invalid_argument(std::string(field) + " has " + std::to_string(bytes.size()) +
                                " bytes; " + std::to_string(key.size()) + " are needed");
  std::copy(bytes.begin(), bytes.end(), key.begin());
}

}  // namespace

void put_keys(const SessionKeys& keys, control::JoinAccepted& accepted) {
  accepted.suite = keys.suite;
  accepted.secret_up = secret_of(keys.up);
  accepted.secret_down = secret_of(keys.down);
}

SessionKeys take_keys(control::JoinAccepted& accepted) {
  SessionKeys keys{.suite = accepted.suite};
  copy_key("secret_up", accepted.secret_up, keys.up);
  copy_key("secret_down", accepted.secret_down, keys.down);
  if (keys.up == keys.down) throw std::invalid_argument("secret_up and secret_down are equal");
  accepted.secret_up = Secret();
  accepted.secret_down = Secret();
  return keys;
}

}  // namespace feltwire
