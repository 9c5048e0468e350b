#pragma once

#include <memory>

#include "server/fleet/directory.hpp"
#include "server/fleet/nats_options.hpp"

namespace feltwire {

/// The one directory in memory of all hosts in this process.
std::shared_ptr<Directory> memory_directory();

/// Loads the shared object ../lib/feltwire/feltwire-nats.so, seen from this program, and opens the
/// directory. Throws std::runtime_error with the remedy if it is not installed, or as
/// NatsDirectory does.
std::shared_ptr<Directory> open_nats_directory(const NatsOptions& options);

}  // namespace feltwire
