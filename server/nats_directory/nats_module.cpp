// The directory on NATS servers as a shared object that a server loads for a fleet alone: other
// servers start without the client library of NATS.

#include "server/nats_directory/nats_directory.hpp"

/// As open_nats_directory() of server/fleet_host/open_directory.cpp expects it.
extern "C" __attribute__((visibility("default"))) feltwire::Directory* feltwire_open_nats_directory(
    const feltwire::NatsOptions* options) {
  return new feltwire::NatsDirectory(*options);
}
