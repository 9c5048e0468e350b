#pragma once
// Reads the files that users name.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace feltwire {

/// Reads a regular file of at most `most` bytes. It refuses a pipe, a device, a socket or a folder
/// at once, without waiting for the other end. It reads a file that grows only up to the limit.
/// Throws FileError "FILE: what is wrong; remedy". `remedy` is the advice for a file that does not
/// exist. If the calling thread has a FileReadingScope (core/base/captured_files.hpp), that decides
/// the source of the bytes and whether they are kept.
std::string read_regular_file(const std::filesystem::path& file, std::size_t most,
                              std::string_view remedy = "check the path");

}  // namespace feltwire
