#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/time.hpp"
#include "protocol/crypto/secret.hpp"

namespace feltwire {

/// How a host reaches the NATS servers of its fleet. Both ends show a certificate of the fleet's
/// authority, and the host also gives a user and a password.
struct NatsOptions {
  std::vector<std::string> servers;        // tls://HOST:PORT
  std::filesystem::path authority;         // PEM, of the servers' certificates
  std::filesystem::path certificate, key;  // PEM, of this host
  std::string user;
  Secret password;
  int replicas = 3;  // of each bucket: as many servers as there are, 5 at most
  Nanoseconds patience = std::chrono::seconds(1);  // for each answer
  Nanoseconds open = std::chrono::seconds(30);     // until the servers answer at the start
};

}  // namespace feltwire
