// Takes arbitrary text as a token file and as a client's token. The result must be an error with
// its place, or tokens that are equal after a rewrite. The text must not authorize a client by
// chance.

#include "server/access/tokens.hpp"

#include "core/base/json_document.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

void keep(const Tokens& tokens, const std::string& shown) {
  const std::string written = json(tokens);
  const Tokens again = parse_tokens(written, "tokens.json");
  require(again.size() == tokens.size() && json(again) == written,
          "tokens say the same when they are written again");
  for (const Token& token : tokens) {
    require(find_token(tokens, token.id) == &token, "each id is there once");
    require(authenticate(tokens, "fw_" + token.id + "_" + shown, {}) == nullptr,
            "nobody hits a secret by chance");
  }
  require(authenticate(tokens, shown, {}) == nullptr, "a file's text is no token");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string text = fuzz::text(data, size);
  try {
    fuzz::keep(parse_tokens(text, "tokens.json"), text);
  } catch (const FileError& error) {
    fuzz::require_place(error.what(), "tokens.json");
  }
  return 0;
}
