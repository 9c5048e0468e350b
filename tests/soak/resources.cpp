#include "tests/soak/resources.hpp"

#include <malloc.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace feltwire::soak {

std::size_t resident_memory() {
  std::ifstream in("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  if (!(in >> all >> resident)) throw std::runtime_error("/proc/self/statm cannot be read");
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

std::size_t heap_in_use() {
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

std::size_t descriptors() {
  // The count always includes the descriptor of the listing itself.
  const auto all = std::filesystem::directory_iterator("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

}  // namespace feltwire::soak
