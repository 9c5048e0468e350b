#pragma once
// A libusb-1.0 with a Falcon; the fuzz target decides its transfers. The library exports
// play_script().

#include <cstdint>

namespace stand_in {

/// Decides the results of libusb's transfers from their relevant arguments.
class UsbScript {
 public:
  virtual ~UsbScript() = default;
  virtual int control(std::uint8_t what, std::uint16_t value) = 0;
  virtual int write(const std::uint8_t* bytes, int count, int* sent) = 0;
  virtual int read(std::uint8_t* room, int most, int* came) = 0;
};

}  // namespace stand_in
