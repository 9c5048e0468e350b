#pragma once
// The thread that talks to a Falcon over USB, so that the servo thread neither waits nor allocates.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "client/device/sample_mailbox.hpp"
#include "client/drivers/novint/falcon_board.hpp"
#include "client/drivers/novint/usb_line.hpp"
#include "core/base/ring.hpp"

namespace feltwire::falcon {

enum class AnswerStatus : std::uint8_t {
  none,     // no whole answer in time
  whole,    // an answer of the right length, with its first byte
  garbled,  // bytes that are no answer
  unsent,   // the device did not take the whole request
  gone      // the device is gone
};
struct Patience {
  Nanoseconds send, answer;  // for the request, and for the whole answer after it
};
/// Sends one request and collects its answer. It may block and allocate: not for the servo thread.
AnswerStatus ask(UsbLine& line, const Packet& request, Answer& answer, const Patience& patience);

/// Sends requests and brings their answers. After let_go() each request is one for no force.
class FalconLine {
 public:
  /// Throws std::system_error where the system gives no thread.
  explicit FalconLine(std::unique_ptr<UsbLine> line);
  /// Asks for no force a last time.
  ~FalconLine();
  FalconLine(const FalconLine&) = delete;
  FalconLine& operator=(const FalconLine&) = delete;

  /// Servo thread, without waiting. False: older requests have not been sent yet.
  bool post(const Packet& request) noexcept;
  struct LineAnswer {
    AnswerStatus kind = AnswerStatus::none;
    Packet packet{};
  };
  /// Servo thread: what has come, or comes by `latest`.
  LineAnswer receive(Nanoseconds latest) noexcept;
  /// Servo thread: throws away what has come.
  void forget() noexcept;
  /// Any thread, any signal handler.
  void let_go() noexcept;

 private:
  void run() noexcept;
  void exchange(const Packet& request) noexcept;

  std::unique_ptr<UsbLine> line_;
  Wake servo_wake_, line_wake_;
  Ring<Packet> requests_{8};
  Ring<LineAnswer> answers_{64};
  std::atomic<bool> let_go_{false}, over_{false}, gone_{false};
  Answer answer_;  // of the thread
  std::thread thread_;
};

}  // namespace feltwire::falcon
