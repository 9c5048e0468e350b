#pragma once
// The file with the tokens. A running server reads it, `feltwire-server token` changes it.

#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/access/tokens.hpp"

namespace feltwire {

/// The tokens of a running server.
class TokenFile {
 public:
  /// Reads the file. Tokens of the file `more` count, too; it may be missing, and come later. Of
  /// two tokens with one id that of `file` counts. Throws FileError.
  explicit TokenFile(std::filesystem::path file, std::filesystem::path more = {});
  /// Tokens without a file, which never change.
  explicit TokenFile(Tokens tokens) : tokens_(std::move(tokens)) {}

  /// Reads each file again that has changed. If one cannot be used, its tokens stay, and the error
  /// is returned, once. A file that could not be read to its end is tried again with the next call.
  std::optional<std::string> refresh();

  const Tokens& tokens() const { return tokens_; }

 private:
  /// Identifies one version of the file; empty: there is none.
  struct Stamp {
    ino_t inode = 0;
    off_t size = 0;
    std::int64_t seconds = 0, nanoseconds = 0;
    mode_t mode = 0;  // the mode decides whether the file is read
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  static Stamp stamp_of(const std::filesystem::path& file);
  struct Part {
    std::filesystem::path file;
    Stamp read;        // of the newest text that was read
    std::string said;  // the last error; empty: there is none
    Tokens tokens;
  };
  static std::optional<std::string> refresh(Part& part, const Stamp& now);
  void gather();

  std::vector<Part> parts_;
  Tokens tokens_;  // of all parts
};

/// Reads the file (missing: no tokens), calls `change` and writes the result back, while no other
/// process does the same: simultaneous writers wait for each other. Throws FileError, and the
/// exceptions of `change`: then nothing is written.
void change_tokens(const std::filesystem::path& file, const std::function<void(Tokens&)>& change);

}  // namespace feltwire
