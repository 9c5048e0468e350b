#pragma once
// The tokens of a whole fleet, as one host knows them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/access/tokens.hpp"
#include "server/fleet/directory.hpp"

namespace feltwire {

/// The most tokens of a fleet.
inline constexpr std::size_t kMostFleetTokens = 10'000;

/// The value of a token in the directory. Its key is the token's id.
std::string encode(const Token& token);
/// Empty if the entry is no token, or that of another key.
std::optional<Token> decode_token(const DirectoryEntry& entry);

/// The token as it is after its revocation: it has expired long ago.
Token revoked(Token token);

/// A directory may lose what it has acknowledged, and answer late or twice. So a host forgets no
/// token that it has seen, and of two ends of its validity the earlier one counts. Hosts that have
/// seen the same entries in any order have the same tokens, and a revocation that one host has seen
/// comes to all. The file keeps the tokens for a start without the directory; the server reads it
/// besides its own (TokenFile). For one thread.
class FleetTokens {
 public:
  /// Reads the file; a missing one has no tokens. Throws FileError.
  explicit FleetTokens(std::filesystem::path file);

  /// Takes an entry of the directory. Ignores one that is no token, and a new one beyond
  /// kMostFleetTokens.
  void see(const DirectoryEntry& entry);
  /// Whether the file lacks something.
  bool changed() const { return changed_; }
  /// Writes the file. Throws FileError.
  void save();

  /// A compare-and-swap of the directory.
  struct Write {
    std::string key, value;
    std::uint64_t revision = 0;
  };
  /// The writes that the directory lacks. `listed`: all its entries.
  std::vector<Write> missing(const std::vector<DirectoryEntry>& listed) const;

 private:
  std::filesystem::path file_;
  std::map<std::string, Token> tokens_;  // by id
  bool changed_ = false;
};

}  // namespace feltwire
