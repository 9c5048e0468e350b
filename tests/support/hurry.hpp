#pragma once
// While a Hurry lives, sleep_for() takes a tenth of the time in all threads of the program. It
// helps drivers that wait by the clock for stand-ins in virtual time.

namespace feltwire::test {

class Hurry {
 public:
  Hurry();
  ~Hurry();
  Hurry(const Hurry&) = delete;
  Hurry& operator=(const Hurry&) = delete;
};

}  // namespace feltwire::test
