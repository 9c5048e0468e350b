#pragma once

#include <utility>
#include <vector>

#include "protocol/crypto/paseto.hpp"

namespace feltwire {

/// The keys with which one host signs tickets. Two are valid at a time, so that a change of keys
/// refuses no ticket: the next key is announced before it signs, and the former one stays valid
/// after it.
class SigningKeys {
 public:
  explicit SigningKeys(const paseto::SigningKey& key) : keys_{key} {}

  /// Signs from now on.
  const paseto::SigningKey& signing() const { return keys_.front(); }

  /// The keys that the other hosts accept, for the heartbeat: one or two.
  std::vector<paseto::PublicKey> valid() const {
    std::vector<paseto::PublicKey> valid;
    for (const paseto::SigningKey& key : keys_) valid.push_back(key.public_key());
    return valid;
  }

  /// Makes a key valid that does not sign yet. The former key is valid no more: call it when all
  /// of its tickets have expired.
  void announce(const paseto::SigningKey& next) {
    keys_.resize(1, next);
    keys_.push_back(next);
  }

  /// The announced key signs from now on; call it when every host has seen the announcement. The
  /// key before it stays valid. Without an announced key nothing changes.
  void change() {
    if (keys_.size() == 2) std::swap(keys_.front(), keys_.back());
  }

 private:
  std::vector<paseto::SigningKey> keys_;  // the first signs
};

}  // namespace feltwire
