#pragma once
// A serial converter of FTDI's on USB, through libusb-1.0, which is loaded while the program runs.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/drivers/common/shared_library.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A converter, with its interface claimed. All calls may block, up to the time that they are
/// given, and allocate: they are not for the servo thread. One thread at a time.
class UsbLine {
 public:
  /// The device with this number of those with these USB ids. Throws std::runtime_error that says
  /// what is wrong and the remedy.
  UsbLine(std::uint16_t vendor, std::uint16_t product, int number);
  ~UsbLine();
  UsbLine(const UsbLine&) = delete;
  UsbLine& operator=(const UsbLine&) = delete;

  enum class Request : std::uint8_t {
    reset = 0,
    modem = 1,
    flow = 2,
    baud = 3,
    data = 4,
    latency = 9
  };
  /// False: it did not take it.
  bool control(Request request, std::uint16_t value);
  /// The number of bytes that the device took; none: it is gone.
  std::optional<std::size_t> write(std::span<const std::uint8_t> bytes, Nanoseconds patience);
  /// A packet, without the converter's own two bytes; 0: none had come by then; none: it is gone.
  std::optional<std::size_t> read(std::span<std::uint8_t> room, Nanoseconds patience);

  /// "FILE, version 1.0.26", of libusb. Throws std::runtime_error with the remedy.
  static std::string library();

 private:
  struct Calls;
  static std::unique_ptr<Calls> load();
  void open(std::uint16_t vendor, std::uint16_t product, int number);
  void close() noexcept;

  std::unique_ptr<Calls> call_;
  void* context_ = nullptr;
  void* device_ = nullptr;
};

}  // namespace feltwire
