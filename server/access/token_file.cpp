#include "server/access/token_file.hpp"

#include <set>
#include <string_view>

#include "core/base/json_document.hpp"
#include "core/base/pending_file.hpp"
#include "protocol/crypto/private_file.hpp"
#include "server/access/file_lock.hpp"

namespace feltwire {
namespace {

/// Reads the tokens. Throws FileError if other users may read the file, or write it and so add
/// tokens.
Tokens read_tokens(const std::filesystem::path& file) {
  if (const auto open = exposure(file)) throw FileError(*open);
  return parse_tokens(read_text(file), file.string());
}

}  // namespace

TokenFile::TokenFile(std::filesystem::path file, std::filesystem::path more) {
  // Take the stamp before the tokens are read, so that refresh() notices every later write.
  const Stamp stamp = stamp_of(file);
  Tokens tokens = read_tokens(file);
  parts_.push_back({std::move(file), stamp, {}, std::move(tokens)});
  if (!more.empty()) {
    const Stamp there = stamp_of(more);
    Tokens others = there == Stamp{} ? Tokens{} : read_tokens(more);
    parts_.push_back({std::move(more), there, {}, std::move(others)});
  }
  gather();
}

std::optional<std::string> TokenFile::refresh() {
  std::optional<std::string> wrong;
  bool changed = false;
  for (Part& part : parts_) {
    const Stamp now = stamp_of(part.file);
    if (now == part.read) continue;
    changed = true;
    if (auto error = refresh(part, now)) wrong = std::move(error);
  }
  if (changed) gather();
  return wrong;
}

std::optional<std::string> TokenFile::refresh(Part& part, const Stamp& now) {
  bool whole = false;
  try {
    if (const auto open = exposure(part.file)) throw FileError(*open);
    const std::string text = read_text(part.file);
    whole = true;
    part.tokens = parse_tokens(text, part.file.string());
    part.read = now;
    part.said.clear();
    return std::nullopt;
  } catch (const FileError& error) {
    // Do not read a wrong text again until the file changes. Try again if the file could not be
    // read, because the cause may be temporary (for example, no free descriptor).
    if (whole) part.read = now;
    if (part.said == error.what()) return std::nullopt;
    return part.said = error.what();
  }
}

void TokenFile::gather() {
  tokens_.clear();
  std::set<std::string_view> ids;
  for (const Part& part : parts_)
    for (const Token& token : part.tokens)
      if (ids.insert(token.id).second) tokens_.push_back(token);
}

TokenFile::Stamp TokenFile::stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec,
          status.st_mode};
}

void change_tokens(const std::filesystem::path& file, const std::function<void(Tokens&)>& change) {
  const FileLock lock(file.string() + ".lock");
  remove_leftovers(file);
  Tokens tokens;
  if (std::filesystem::exists(file)) tokens = read_tokens(file);
  change(tokens);
  replace_file(file, json(tokens), kPrivate);
}

}  // namespace feltwire
