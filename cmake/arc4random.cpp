// libstdc++.a of Debian 12 calls arc4random() of glibc 2.36. This one makes a self-contained
// library run with glibc 2.35.
#include <sys/random.h>

#include <cstdint>
#include <cstdlib>

extern "C" __attribute__((visibility("hidden"))) std::uint32_t arc4random() {
  std::uint32_t number = 0;
  if (getentropy(&number, sizeof number) != 0) std::abort();
  return number;
}
