#pragma once
// Errors about an MJCF or URDF file that feltwire itself finds, unlike MuJoCo's.

#include <string>
#include <utility>

#include "core/base/file_error.hpp"

namespace feltwire {

/// A model that feltwire refuses. what() may quote names of the model; without_names() quotes
/// nothing of it, for a file whose text may not be shown.
class RefusedModel : public FileError {
 public:
  RefusedModel(const std::string& message, std::string without_names)
      : FileError(message), without_names_(std::move(without_names)) {}
  /// A message that quotes nothing of the model.
  explicit RefusedModel(const std::string& message) : RefusedModel(message, message) {}

  const std::string& without_names() const { return without_names_; }

 private:
  std::string without_names_;
};

}  // namespace feltwire
