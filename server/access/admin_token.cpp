#include "server/access/admin_token.hpp"

#include "core/base/pending_file.hpp"
#include "server/access/file_lock.hpp"
#include "server/access/security.hpp"

namespace feltwire {

std::filesystem::path admin_token_file(const SecurityOptions& config) {
  if (!config.tokens.empty()) return {};
  return local_token_file(config).parent_path() / "admin.token";
}

void make_admin_token(const SecurityOptions& config) {
  const std::filesystem::path file = admin_token_file(config);
  if (file.empty()) return;
  const FileLock lock(file.parent_path() / "lock");  // two servers may start at the same time
  remove_leftovers(file);
  if (std::filesystem::exists(file)) return;
  const IssuedToken admin = issue_token("local-admin", "*", Role::admin, std::nullopt);
  change_tokens(token_file(config), [&](Tokens& tokens) { tokens.push_back(admin.token); });
  replace_file(file, admin.text.text(), kPrivate);
}

}  // namespace feltwire
