#pragma once
// The error of a mesh file that cannot be read.

#include <string>

#include "core/base/file_error.hpp"
#include "core/mesh/mesh_file.hpp"

namespace feltwire::test {

/// The error text with which the file is refused; "no error" if it is read.
inline std::string error_of(const std::string& bytes, const std::string& name) {
  try {
    parse_mesh(bytes, name, 1.0);
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace feltwire::test
