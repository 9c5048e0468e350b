// Runs MuJoCo's loader in its own process (mjcf_reader.cpp).

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/base/cancellation.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"

namespace feltwire::mujoco {
namespace {

constexpr const char* kReader = "feltwire-mjcf";

// Numbers of the descriptors in the child process.
constexpr int kInput = 3, kModel = 4, kError = 5, kFiles = 6, kFirstFree = 7;

/// A file in memory (memfd).
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) {
    const int made = memfd_create(name, MFD_CLOEXEC);
    descriptor_ = made < 0 ? -1 : fcntl(made, F_DUPFD_CLOEXEC, kFirstFree);
    const int error = errno;
    if (made >= 0) close(made);
    if (descriptor_ < 0)
      throw std::system_error(error, std::generic_category(), "memory for an MJCF file");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }

  int descriptor() const { return descriptor_; }
  void write(const std::string& text) const {
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t n = ::write(descriptor_, text.data() + at, text.size() - at);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) throw std::system_error(errno, std::generic_category(), "memory for an MJCF file");
      at += static_cast<std::size_t>(n);
    }
  }
  std::string text(std::size_t most) const {
    std::string text(most, '\0');
    const ssize_t n = pread(descriptor_, text.data(), most, 0);
    text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return text;
  }

 private:
  // The number is at least kFirstFree, so that the child's descriptors do not replace this
  // descriptor.
  int descriptor_ = -1;
};

/// Returns the path of feltwire-mjcf: beside this program, or else in the build folder (for tests).
std::string reader() {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto beside = self.parent_path() / kReader;
    if (access(beside.c_str(), X_OK) == 0) return beside;
  }
  return FELTWIRE_MJCF_READER;
}

std::string place(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

/// A child process. The destructor kills the process unless end() has waited for it.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (ended_) return;
    kill(id_, SIGKILL);
    wait(0);
  }

  /// Waits for the process and returns the status of waitpid(). Throws Cancelled if the work of
  /// this thread is cancelled.
  int end() {
    const int handle =
        current_work() != nullptr ? static_cast<int>(syscall(SYS_pidfd_open, id_, 0)) : -1;
    const MaybeDescriptor owned(handle);
    while (current_work() != nullptr && !wait(WNOHANG)) {
      constexpr int kLook = 20;        // [ms] interval between checks for a cancelled work
      pollfd ends{handle, POLLIN, 0};  // poll() ignores a negative descriptor.
      poll(&ends, 1, kLook);
      check_cancelled();
    }
    if (!ended_) wait(0);
    return status_;
  }

 private:
  struct MaybeDescriptor {
    explicit MaybeDescriptor(int given) : descriptor(given) {}
    MaybeDescriptor(const MaybeDescriptor&) = delete;
    MaybeDescriptor& operator=(const MaybeDescriptor&) = delete;
    ~MaybeDescriptor() {
      if (descriptor >= 0) close(descriptor);
    }
    int descriptor;
  };

  /// Calls waitpid(). Returns true if the child process has ended.
  bool wait(int options) {
    pid_t found = 0;
    do found = waitpid(id_, &status_, options);
    while (found < 0 && errno == EINTR);
    ended_ = found != 0;
    // Another part of the process has collected the status, so the result is unknown.
    if (found < 0) status_ = SIGKILL;
    return ended_;
  }

  pid_t id_;
  int status_ = 0;
  bool ended_ = false;
};

/// Descriptors for the child process.
struct Ends {
  int input = -1;  // -1: no input
  int model, error, files;
};

/// Runs feltwire-mjcf and returns waitpid()'s status. Throws std::system_error if it cannot start.
int run_reader(const std::string& file, const std::string& root, const std::string& text,
               const Ends& ends) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends.model, kModel);
  posix_spawn_file_actions_adddup2(&actions, ends.error, kError);
  posix_spawn_file_actions_adddup2(&actions, ends.files, kFiles);
  if (ends.input >= 0) posix_spawn_file_actions_adddup2(&actions, ends.input, kInput);
  if (ends.input < 0) posix_spawn_file_actions_addopen(&actions, kInput, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  for (const int chatter : {STDOUT_FILENO, STDERR_FILENO})  // This silences Qhull.
    posix_spawn_file_actions_addopen(&actions, chatter, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, kFirstFree);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const std::string program = reader(), model_place = place(kModel), error_place = place(kError),
                    files_place = place(kFiles);
  const std::array<const char*, 8> words = {
      program.c_str(),     file.c_str(), model_place.c_str(), error_place.c_str(),
      files_place.c_str(), root.c_str(), text.c_str(),        nullptr};
  pid_t child = 0;
  const int failed = posix_spawn(&child, program.c_str(), &actions, &attributes,
                                 const_cast<char* const*>(words.data()), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    throw std::system_error(failed, std::generic_category(), program + " cannot be started");
  return Child(child).end();
}

/// Returns the quoted text after a word, or an empty text.
std::string quoted_behind(const std::string& words, std::string_view word) {
  std::size_t begin = words.find(word);
  if (begin == std::string::npos) return {};
  begin = words.find('\'', begin + word.size());
  const std::size_t end = begin == std::string::npos ? begin : words.find('\'', begin + 1);
  return end == std::string::npos ? std::string() : words.substr(begin + 1, end - begin - 1);
}

/// Returns a hint that names this MuJoCo version and the unknown word, because the file may need a
/// newer version.
std::string of_this_version(const std::string& words) {
  const std::string element = quoted_behind(words, "Element");
  const std::string where = element.empty() ? "" : " in <" + element + ">";
  std::string unknown;
  if (words.find("unrecognized element") != std::string::npos)
    unknown = "the element <" + element + ">";
  else if (const auto attribute = quoted_behind(words, "unrecognized attribute:");
           !attribute.empty())
    unknown = "the attribute '" + attribute + "'" + where;
  else if (const auto keyword = quoted_behind(words, "invalid keyword:"); !keyword.empty())
    unknown = "the word '" + keyword + "'" + where;
  else
    return {};
  return "; the MuJoCo here is version " + std::string(mj_versionString()) +
         ", which does not know " + unknown +
         "; if the file was made for a newer one, remove it or write it for this version";
}

/// Returns the reason why MuJoCo's loader has made no model.
std::string reason(int status, const MemoryFile& error) {
  constexpr std::size_t kMostWords = 1000;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return "MuJoCo's loader took ten minutes of computing and was ended; simplify the model";
  if (WIFSIGNALED(status))
    return "MuJoCo's loader crashed on it (signal " + std::to_string(WTERMSIG(status)) +
           "); correct the file, MuJoCo's own programs may say more";
  std::string words = error.text(kMostWords);
  while (!words.empty() && words.back() == '\n') words.pop_back();
  for (char& c : words)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  if (words.find("could not create mjData") != std::string::npos)
    return "it takes more memory than there is, or than the 2 GB that MuJoCo may take at once for "
           "contacts, joints with limits or friction and its stack; have fewer bodies, or a "
           "smaller "
           "<size>";
  if (words.empty()) return "MuJoCo cannot compile it, and gives no reason";
  return words + of_this_version(words);
}

/// Splits a list of names and drops duplicates. Each name ends with a zero byte.
std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  for (std::size_t at = 0, end = list.find('\0'); end != std::string::npos;
       at = end + 1, end = list.find('\0', at))
    if (std::string name = list.substr(at, end - at); std::ranges::find(names, name) == names.end())
      names.push_back(std::move(name));
  return names;
}

/// Loads a file with feltwire-mjcf. If `text` is given, it replaces the text of the file.
Loaded load(const std::string& file, const std::string* text, const std::string& root = {}) try {
  constexpr std::size_t kMostNames = 1 << 20;  // [bytes] largest length of the list of file names
  const MemoryFile input("input"), model("model"), error("error"), files("files");
  if (text != nullptr) input.write(*text);
  const bool replaced = text != nullptr && file != place(kInput);
  const int status = run_reader(file, root, replaced ? place(kInput) : "",
                                {.input = text != nullptr ? input.descriptor() : -1,
                                 .model = model.descriptor(),
                                 .error = error.descriptor(),
                                 .files = files.descriptor()});
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return {nullptr, reason(status, error)};
  Loaded loaded{read_binary(place(model.descriptor())), {}, names_in(files.text(kMostNames))};
  if (loaded.model == nullptr) loaded.error = "MuJoCo's model of it cannot be read back";
  return loaded;
} catch (const std::system_error& error) {
  return {nullptr, std::string("MuJoCo's loader cannot be run: ") + error.what()};
}

}  // namespace

Loaded load_text(const std::string& xml) { return load(place(kInput), &xml); }

Loaded load_file(const std::string& file, const std::string& root, const std::string* text) {
  return load(file, text, root);
}

}  // namespace feltwire::mujoco
