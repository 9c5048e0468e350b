#pragma once
// Something put by, so that a program that has run out of everything can still write its report.

#include <cstddef>
#include <memory>

namespace feltwire {

class Reserve {
 public:
  /// Takes a descriptor and some memory. Throws std::system_error or std::bad_alloc.
  Reserve();
  ~Reserve() { give_back(); }
  Reserve(const Reserve&) = delete;
  Reserve& operator=(const Reserve&) = delete;
  /// From now on the system has one descriptor and this memory more to give.
  void give_back() noexcept;

 private:
  int descriptor_ = -1;
  std::unique_ptr<std::byte[]> memory_;
};

}  // namespace feltwire
