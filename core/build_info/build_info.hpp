#pragma once
// The version of feltwire, and how it was built.

#include <string>

namespace feltwire {

/// "0.1.0 4d7d03fe1c52": the version, and the commit of the build, with "-dirty" if files were
/// changed, or "unknown" without a git checkout. Join messages and reports contain it.
const std::string& version();

/// For `--version`, in one line: the version, the compiler, the kind of build, "client alone" for a
/// build of the thin client, and the sanitizers in it.
std::string build_info(const std::string& program);

/// The two parts of build_info() after the version: "GNU 12.2.0" and "Release".
const char* compiler();
const char* build_type();

}  // namespace feltwire
