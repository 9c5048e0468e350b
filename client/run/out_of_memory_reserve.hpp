#pragma once
// Reserves resources, so that a program that has run out of them can still write its report.

namespace feltwire {

class OutOfMemoryReserve {
 public:
  /// Reserves a descriptor and some memory. Throws std::system_error or std::bad_alloc.
  OutOfMemoryReserve();
  ~OutOfMemoryReserve();
  OutOfMemoryReserve(const OutOfMemoryReserve&) = delete;
  OutOfMemoryReserve& operator=(const OutOfMemoryReserve&) = delete;

  /// From now on the system has one more descriptor, and the first operator new that finds no
  /// memory frees the reserved memory and tries again. Without that, some destructors that allocate
  /// (JSON's) would end the program. Only one may exist in a program.
  void stand_in() noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace feltwire
