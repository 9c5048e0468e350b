#pragma once
// The wishes of an operator to the hosts of a fleet, through its directory. Each function waits for
// the hosts, for some seconds at most, and returns what has become of it, in a line for people. It
// throws std::invalid_argument if there is no such host or scene, and std::runtime_error if the
// wish cannot be met.

#include <map>
#include <string>
#include <vector>

#include "server/fleet/directory.hpp"
#include "server/fleet/scene_record.hpp"

namespace feltwire {

/// All entries of a bucket. Throws std::runtime_error if no answer came in time.
std::vector<DirectoryEntry> entries_of(Directory& directory, Bucket bucket);
/// The heartbeats of all hosts, by their names. Throws std::runtime_error.
std::map<std::string, HostRecord> host_records(Directory& directory);
/// The records of all scenes, by their names. Throws std::runtime_error.
std::map<std::string, SceneRecord> scene_records(Directory& directory);

/// The host takes no further scene, and hands its own over.
std::string drain_host(Directory& directory, const std::string& host);
/// The host takes scenes again.
std::string undrain_host(Directory& directory, const std::string& host);
/// The owner of the scene hands it over to the host.
std::string move_scene(Directory& directory, const std::string& scene, const std::string& host);

}  // namespace feltwire
