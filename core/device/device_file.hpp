#pragma once
// A device's specification from a file, with the sources of its numbers.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/device/device_spec.hpp"

namespace feltwire {

/// The sources of the numbers of a specification, by the name of the field. A number without a
/// source is not in the list. A source that begins with "assumption" was not measured or found.
using SpecSources = std::map<std::string, std::string, std::less<>>;

struct SourcedSpec {
  DeviceSpec spec;
  SpecSources sources;
  bool tells_lag = false;  // actuation_lag was given, if only as 0
  bool tells_transmission =
      false;  // transmission_stiffness was given, if only as 0 for a rigid one
};

/// The request for a specification on a command line.
struct SpecRequest {
  std::string name_or_file;        // a built-in name, or FILE.json; empty: the driver's own
  std::optional<Damping> damping;  // [N s/m] in place of the specification's
  std::optional<double> mass;      // [kg] the same for the apparent mass, as its lower bound
};

/// Reads a specification (JSON against core/device/device_spec.fbs). Throws FileError that names
/// the file, the line, the field and the remedy.
SourcedSpec load_sourced_spec(const std::filesystem::path& file);

/// Finds the device of a command line: a built-in one by its name, or a file by a path that ends in
/// .json. Throws std::invalid_argument that lists the built-in names, or FileError.
SourcedSpec sourced_spec(std::string_view name_or_file);
DeviceSpec device_spec(std::string_view name_or_file);

/// The specification that the request names, or else `usual` (a name or a file). Throws as
/// sourced_spec() does, and DeviceSpecError if a number of the request is not possible.
SourcedSpec requested_spec(const SpecRequest& request, std::string_view usual);

/// The specification with the numbers of the request in it. Throws DeviceSpecError.
SourcedSpec overruled(SourcedSpec found, const SpecRequest& request);

/// The built-in devices with their sources, in the order of builtin_devices().
std::span<const SourcedSpec> sourced_builtin_devices();

}  // namespace feltwire
