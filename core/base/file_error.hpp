#pragma once

#include <stdexcept>

namespace feltwire {

/// A file that cannot be used: what() reads "file:line: field: what is wrong; remedy".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace feltwire
