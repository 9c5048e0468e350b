#pragma once
// While one of these lives, the threads of the program sleep a tenth of the time: sleep_for(). For
// stand-ins whose own time is virtual, and drivers that wait for them by the clock.

namespace feltwire::test {

class Hurry {
 public:
  Hurry();
  ~Hurry();
  Hurry(const Hurry&) = delete;
  Hurry& operator=(const Hurry&) = delete;
};

}  // namespace feltwire::test
