// feltwire-mjcf: reads one MJCF file with MuJoCo's loader and writes the compiled model. A server
// runs it as a child process: MuJoCo's loader leaves its own C++ code by longjmp and may crash on a
// bad file, and neither may happen in a process that holds a hand.
//   feltwire-mjcf FILE MODEL ERROR
// Status 0: MODEL holds the binary model. Status 1: ERROR holds MuJoCo's words.

#include <mujoco/mujoco.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>

namespace {

const char* error_file = nullptr;

[[noreturn]] void refuse(const char* words) {
  if (FILE* out = std::fopen(error_file, "wb")) {
    std::fputs(words, out);
    std::fclose(out);
  }
  _exit(1);  // no destructor of a half read model is run
}

/// Of a loader that never ends, or that takes all memory there is.
void limit_resources() {
  constexpr rlim_t kSeconds = 600;
  const rlimit time{kSeconds, kSeconds}, none{0, 0};
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &none);
#ifndef FELTWIRE_SANITIZED                     // whose own memory counts
  constexpr rlim_t kMemory = rlim_t{4} << 30;  // [bytes]
  const rlimit memory{kMemory, kMemory};
  setrlimit(RLIMIT_DATA, &memory);
#endif
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fputs("feltwire-mjcf: is run by feltwire-server to read an MJCF file\n", stderr);
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  limit_resources();
  error_file = words[3];
  mju_user_error = refuse;
  mju_user_warning = [](const char*) {};  // by itself it writes a file
  std::array<char, 1000> error{};
  mjModel* model = mj_loadXML(words[1], nullptr, error.data(), static_cast<int>(error.size()));
  if (model == nullptr) refuse(error[0] != '\0' ? error.data() : "MuJoCo gave up on it");
  mj_saveModel(model, words[2], nullptr, 0);
  _exit(0);
}
