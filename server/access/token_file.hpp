#pragma once
// The file that the tokens stand in: read by a running server, changed by `feltwire-server token`.

#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "server/access/tokens.hpp"

namespace feltwire {

/// The tokens as a server that runs sees them.
class TokenFile {
 public:
  /// Reads the file. Throws FileError.
  explicit TokenFile(std::filesystem::path file);
  /// Tokens that stand in no file and never change.
  explicit TokenFile(Tokens tokens) : tokens_(std::move(tokens)) {}

  /// Reads the file again if it is another than was read last. When that cannot be used the tokens
  /// stay as they are; what is wrong with it is returned, once. A file that could not be read to
  /// its end is tried again with the next call.
  std::optional<std::string> refresh();

  const Tokens& tokens() const { return tokens_; }

 private:
  /// Tells one writing of the file from another; empty: there is none.
  struct Stamp {
    ino_t inode = 0;
    off_t size = 0;
    std::int64_t seconds = 0, nanoseconds = 0;
    mode_t mode = 0;  // who may read it changes whether it is read
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  Stamp stamp() const;

  std::filesystem::path file_;
  Stamp read_;        // of the newest text that was looked at
  std::string said_;  // of what is wrong; empty: nothing is
  Tokens tokens_;
};

/// Reads the file (none: no tokens), has `change` change them and writes them back, while no other
/// process does the same: what two writers do at once is done one after the other. Throws
/// FileError, and what `change` throws: then nothing is written.
void change_tokens(const std::filesystem::path& file, const std::function<void(Tokens&)>& change);

}  // namespace feltwire
