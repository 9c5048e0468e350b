#pragma once
// The tokens that viewers of the live page show.

#include <asio/ip/address.hpp>
#include <string_view>

#include "server/access/token_file.hpp"
#include "server/access/wrong_tokens.hpp"

namespace feltwire::web {

/// Owns the token file and the limit on wrong tokens. It is on the page's thread.
class ViewerTokens {
 public:
  explicit ViewerTokens(TokenFile file) : file_(std::move(file)) {}

  /// Reads the file again if it has changed; logs the error if it cannot be used. Pointers to
  /// tokens are void from then on.
  void refresh();
  /// The valid token with this text, as the file was read last; null: there is none.
  const Token* authenticate(std::string_view text) const;
  /// The token with this id, which may have expired; null: there is none.
  const Token* find(std::string_view id) const { return find_token(file_.tokens(), id); }
  /// Counts a wrong token or ticket from this address. False: there were too many.
  bool may_try_again(const asio::ip::address& address);

 private:
  TokenFile file_;
  WrongTokens wrong_{0.2, 10.0};
};

}  // namespace feltwire::web
