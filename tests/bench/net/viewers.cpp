#include "tests/bench/net/viewers.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "tests/bench/net/machine.hpp"
#include "tests/server/web/page_client.hpp"

namespace feltwire::netbench {
namespace {

/// The page in the form that test::Page expects.
struct Site {
  std::uint16_t port;
  std::string web_url() const { return "http://127.0.0.1:" + std::to_string(port) + "/"; }
};

[[noreturn]] void view(const Site& site, const std::string& token, int core, int pipe,
                       std::atomic<std::uint64_t>& pictures) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    pin_to(core);
    const sched_param none{};
    sched_setscheduler(0, SCHED_IDLE, &none);
    test::Page page(site, token);
    for (bool first = true; !page.picture().empty(); first = false) {
      ++pictures;
      if (first && ::write(pipe, "", 1) != 1) break;
    }
    std::fprintf(stderr, "feltwire-netbench: a viewer's connection ended\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-netbench: viewer: %s\n", error.what());
  }
  std::_Exit(1);
}

}  // namespace

Viewers::Viewers(int count, std::uint16_t port, const std::string& token, int core) {
  void* memory =
      ::mmap(nullptr, sizeof *pictures_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  int pipe[2];
  if (memory == MAP_FAILED || ::pipe(pipe) != 0) throw std::runtime_error("no viewers");
  pictures_ = new (memory) std::atomic<std::uint64_t>(0);
  for (int i = 0; i < count; ++i) {
    const pid_t process = ::fork();
    if (process < 0) throw std::runtime_error("no process");
    if (process == 0) {
      ::close(pipe[0]);
      view({port}, token, core, pipe[1], *pictures_);
    }
    processes_.push_back(process);
  }
  ::close(pipe[1]);
  char ready;
  for (int i = 0; i < count; ++i)
    if (::read(pipe[0], &ready, 1) != 1) throw std::runtime_error("a viewer got no picture");
  ::close(pipe[0]);
}

Viewers::~Viewers() {
  for (const pid_t process : processes_) {
    ::kill(process, SIGKILL);
    ::waitpid(process, nullptr, 0);
  }
  ::munmap(pictures_, sizeof *pictures_);
}

}  // namespace feltwire::netbench
