#pragma once
// Arrays in the format of numpy.load(): a zip of .npy files, not compressed.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/appended_file.hpp"

namespace feltwire {

class NpzFile {
 public:
  /// Creates or replaces the file. Throws std::runtime_error naming it and the reason, as do the
  /// others; `option` named the file.
  NpzFile(const std::filesystem::path& file, const std::string& option);

  /// An array of `values.size() / width` rows; of width 1 it has one dimension. Throws also where
  /// the file would be beyond the 4 GiB of a zip.
  void add(const std::string& name, std::span<const double> values, std::size_t width = 1);
  void add(const std::string& name, std::span<const std::int64_t> values);
  void finish();

 private:
  void add(const std::string& name, std::string_view type, std::string_view bytes, std::size_t rows,
           std::size_t width);

  AppendedFile file_;
  std::string directory_;
  std::uint16_t entries_ = 0;
};

}  // namespace feltwire
