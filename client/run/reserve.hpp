#pragma once
// Something put by, so that a program that has run out of everything can still write its report.

namespace feltwire {

class Reserve {
 public:
  /// Takes a descriptor and some memory. Throws std::system_error or std::bad_alloc.
  Reserve();
  ~Reserve();
  Reserve(const Reserve&) = delete;
  Reserve& operator=(const Reserve&) = delete;

  /// From now on the system has one descriptor more to give, and the first operator new that finds
  /// no memory gives back what was put by and tries again. Without that, some destructors that
  /// allocate (JSON's) would end the program. One at a time in a program.
  void stand_in() noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace feltwire
