#pragma once
// The names in a folder.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// The names of all entries of a folder, in no order, without "." and ".."; empty if it cannot be
/// read. Throws std::bad_alloc. It uses readdir(): std::filesystem::directory_iterator may end the
/// program if memory runs out (libstdc++ 12).
std::vector<std::string> names_in(const std::filesystem::path& folder);

}  // namespace feltwire
