#include "server/token_file.hpp"

#include "core/scene/json_document.hpp"
#include "server/state_file.hpp"

namespace feltwire {

TokenFile::TokenFile(std::filesystem::path file)
    // The stamp first: what is written after it is noticed.
    : file_(std::move(file)),
      read_(stamp()),
      tokens_(parse_tokens(read_text(file_), file_.string())) {}

std::optional<std::string> TokenFile::refresh() {
  if (file_.empty()) return std::nullopt;
  const Stamp now = stamp();
  if (now == read_) return std::nullopt;
  read_ = now;
  try {
    tokens_ = parse_tokens(read_text(file_), file_.string());
  } catch (const FileError& error) {
    return error.what();
  }
  return std::nullopt;
}

TokenFile::Stamp TokenFile::stamp() const {
  struct stat status {};
  if (::stat(file_.c_str(), &status) != 0) return {};
  return {status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

void change_tokens(const std::filesystem::path& file, const std::function<void(Tokens&)>& change) {
  const FileLock lock(file.string() + ".lock");
  Tokens tokens;
  if (std::filesystem::exists(file)) tokens = parse_tokens(read_text(file), file.string());
  change(tokens);
  write_state(file, json(tokens), kPrivate);
}

}  // namespace feltwire
