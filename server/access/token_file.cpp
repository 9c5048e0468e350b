#include "server/access/token_file.hpp"

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

TokenFile::TokenFile(std::filesystem::path file)
    // Take the stamp before the tokens are read, so that refresh() notices every later write.
    : file_(std::move(file)), read_(stamp()), tokens_(read_tokens(file_)) {}

std::optional<std::string> TokenFile::refresh() {
  if (file_.empty()) return std::nullopt;
  const Stamp now = stamp();
  if (now == read_) return std::nullopt;
  bool whole = false;
  try {
    if (const auto open = exposure(file_)) throw FileError(*open);
    const std::string text = read_text(file_);
    whole = true;
    tokens_ = parse_tokens(text, file_.string());
    read_ = now;
    said_.clear();
    return std::nullopt;
  } catch (const FileError& error) {
    // Do not read a wrong text again until the file changes. Try again if the file could not be
    // read, because the cause may be temporary (for example, no free descriptor).
    if (whole) read_ = now;
    if (said_ == error.what()) return std::nullopt;
    return said_ = error.what();
  }
}

TokenFile::Stamp TokenFile::stamp() const {
  struct stat status {};
  if (::stat(file_.c_str(), &status) != 0) return {};
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
