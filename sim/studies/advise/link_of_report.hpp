#pragma once
// A link as a client measured it.

#include <filesystem>
#include <string>

#include "client/emulated_link/link_options.hpp"

namespace feltwire::advise {

/// The link of a run, from the report of feltwire-client (--report): one-way delays and jitter of
/// its `server_clock`, and the share of its samples without an answer, which counts half for each
/// way. Throws FileError that names the file, the member and the remedy.
TwoWayLinkOptions link_of_report(const std::filesystem::path& file);

/// The link of --link: a report (a path that ends in .json), or text for parse_link(). Throws as
/// both do; for HOST:PORT std::invalid_argument with the command that measures it.
TwoWayLinkOptions link_of(const std::string& text);

}  // namespace feltwire::advise
