// feltwire-mjcf reads one MJCF file with MuJoCo's loader and writes the compiled model. A server
// runs it as a child process, because MuJoCo's loader leaves its own C++ code by longjmp and may
// crash on a bad file. Both would endanger a process that drives a haptic device.
//   feltwire-mjcf FILE MODEL ERROR FILES ROOT TEXT
// Status 0: MODEL holds the binary model. FILES holds the names of all files that were read, each
// followed by a zero byte. Status 1: ERROR holds MuJoCo's message. If ROOT is not empty, the
// program refuses files outside that folder. If TEXT is not empty, this file's text replaces the
// text of FILE. Relative names in TEXT are still relative to FILE.
//
// An MJCF file names other files: includes, meshes, height fields, textures. MuJoCo and its
// libraries open all of them by fopen(). The dynamic linker prefers this program's own fopen() to
// libc's. This fopen() refuses everything but regular files, because opening a pipe would block and
// reading a device might never end.

#include <fcntl.h>
#include <mujoco/mujoco.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/build_info/build_info.hpp"

namespace {

const char* error_file = nullptr;
const char* root = "";
const char *main_file = "", *main_text = "";
int files = -1;  // descriptor of FILES

[[noreturn]] void refuse(const char* words) {
  if (FILE* out = std::fopen(error_file, "wb")) {
    std::fputs(words, out);
    std::fclose(out);
  }
  _exit(1);  // _exit() skips the destructors of a half-read model.
}

[[noreturn]] void refuse_file(const char* name, mode_t mode) {
  const char* kind = S_ISDIR(mode)    ? "a directory"
                     : S_ISFIFO(mode) ? "a pipe"
                     : S_ISSOCK(mode) ? "a socket"
                                      : "a device";
  std::array<char, 900> words{};
  std::snprintf(words.data(), words.size(), "%s: is %s; name a regular file", name, kind);
  refuse(words.data());
}

/// Returns true if the file lies in the root after all links are resolved.
bool is_within_root(const char* name) {
  const std::size_t length = std::strlen(root);
  if (length == 0) return true;
  char* place = realpath(name, nullptr);
  const bool within =
      place != nullptr && std::strncmp(place, root, length) == 0 && place[length] == '/';
  std::free(place);
  return within;
}

/// Adds the name to FILES. On a failure, the recording lacks the file, and its replay reports the
/// missing file.
void note(const char* name) {
  const ssize_t ignored = write(files, name, std::strlen(name) + 1);
  static_cast<void>(ignored);
}

/// Opens regular files only, and never blocks. It opens a pipe without waiting for the other end,
/// and then refuses the pipe.
FILE* open_regular(const char* name, const char* mode) {
  const bool reads = mode[0] == 'r', also = std::strchr(mode, '+') != nullptr;
  const int access = also ? O_RDWR : reads ? O_RDONLY : O_WRONLY;
  const int made = reads ? 0 : O_CREAT | (mode[0] == 'a' ? O_APPEND : O_TRUNC);
  constexpr mode_t kPermissions = 0600;
  if (reads && !is_within_root(name)) {
    errno = ENOENT;
    return nullptr;
  }
  const bool given = reads && *main_text != '\0' && std::strcmp(name, main_file) == 0;
  const int file = open(given ? main_text : name, access | made | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
                        kPermissions);
  if (file < 0) {
    // open() fails with ENXIO for a socket, and for a write-only pipe without a reader.
    struct stat status {};
    if (errno == ENXIO && stat(name, &status) == 0) refuse_file(name, status.st_mode);
    return nullptr;
  }
  struct stat status {};
  if (fstat(file, &status) == 0 && S_ISREG(status.st_mode)) {
    if (reads && files >= 0) note(name);
    return fdopen(file, mode);
  }
  close(file);
  refuse_file(name, status.st_mode);
}

/// Limits this process, because MuJoCo's loader may never end or may take all memory.
void limit_resources() {
  constexpr rlim_t kSeconds = 600;
  const rlimit time{kSeconds, kSeconds}, none{0, 0};
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &none);
#ifndef FELTWIRE_SANITIZED                     // A sanitizer's own memory would count too.
  constexpr rlim_t kMemory = rlim_t{4} << 30;  // [bytes] largest data memory
  const rlimit memory{kMemory, kMemory};
  setrlimit(RLIMIT_DATA, &memory);
#endif
}

}  // namespace

extern "C" FILE* fopen(const char* name, const char* mode) { return open_regular(name, mode); }
extern "C" FILE* fopen64(const char* name, const char* mode) { return open_regular(name, mode); }

int main(int count, char** words) {
  if (count == 2 && std::strcmp(words[1], "--version") == 0) {
    std::puts(feltwire::build_info("feltwire-mjcf").c_str());
    return 0;
  }
  if (count != 7) {
    std::fputs("feltwire-mjcf: is run by feltwire-server to read an MJCF file\n", stderr);
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  limit_resources();
  error_file = words[3];
  root = words[5];
  main_file = words[1];
  main_text = words[6];
  files = open(words[4], O_WRONLY | O_APPEND | O_CLOEXEC);
  mju_user_error = refuse;
  mju_user_warning = [](const char*) {};  // MuJoCo's own handler would write a file.
  std::array<char, 1000> error{};
  mjModel* model = mj_loadXML(words[1], nullptr, error.data(), static_cast<int>(error.size()));
  if (model == nullptr)
    refuse(error[0] != '\0' ? error.data() : "MuJoCo cannot compile it, and gives no reason");
  mj_saveModel(model, words[2], nullptr, 0);
  _exit(0);
}
