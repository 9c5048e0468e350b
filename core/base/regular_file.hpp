#pragma once
// How every file that a user names is read.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace feltwire {

/// The bytes of a regular file of at most `most` bytes. A pipe, a device, a socket or a folder is
/// refused without waiting for anybody at its other end, and a file that grows while it is read
/// ends at the limit. Throws FileError "FILE: what is wrong; remedy", where `remedy` says what to
/// do about a file that is not there.
std::string read_regular_file(const std::filesystem::path& file, std::size_t most,
                              std::string_view remedy = "check the path");

}  // namespace feltwire
