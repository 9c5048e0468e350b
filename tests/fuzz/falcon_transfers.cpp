// Takes any result of a Falcon's USB transfers. A firmware must count as loaded only if every piece
// was echoed, and an answer must have the received bytes. The first byte selects a load or a
// request.

#include <dlfcn.h>

#include <vector>

#include "client/drivers/novint/falcon_firmware.hpp"
#include "client/drivers/novint/falcon_line.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/libusb_script.hpp"

namespace feltwire::fuzz {
namespace {

using namespace falcon;
using Byte = std::uint8_t;
using Sent = std::vector<Byte>;

constexpr int kNoDevice = -4, kTimeout = -7;
constexpr std::size_t kModem = 2, kUsbPacket = 64;
constexpr unsigned kHelloRate = 0x4138, kLoadRate = 0x15;

struct Write {
  Sent bytes;  // bytes that the device took
  bool whole = true;
  unsigned rate = 0;
  Sent heard{};  // bytes received until the next write
};

/// A byte selects the result of each transfer. Without more input the device is gone.
class Converter final : public stand_in::UsbScript {
 public:
  explicit Converter(Input& input) : input_(input) {}

  int control(Byte what, std::uint16_t value) override {
    if (next() == kUnplugged) return gone();
    if (what == 0 && value == 1) waiting_.clear();
    if (what == 3) rate_ = value;
    return 0;
  }

  int write(const Byte* bytes, int count, int* sent) override {
    require(count > 0 && count <= 62, "a write is one packet of USB");
    *sent = 0;
    const Byte how = next();
    if (how == kUnplugged) return gone();
    *sent = how == 254 ? count / 2 : how == 253 ? -1 : how == 252 ? count + 1 : count;
    const int taken = how == 254 ? count / 2 : count;
    writes.push_back({{bytes, bytes + taken}, *sent == count, rate_});
    answer({bytes, static_cast<std::size_t>(taken)});
    return how == 254 ? kTimeout : 0;
  }

  int read(Byte* room, int most, int* came) override {
    require(most >= static_cast<int>(kUsbPacket), "a packet of USB has room");
    *came = 0;
    const Byte how = next();
    if (how == kUnplugged) return gone();
    const std::size_t count = how >= 252 ? kUsbPacket - kModem : how % 63U;
    Sent packet = {0x01, 0x60};
    if (how < 128) {
      const auto end =
          waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(count, waiting_.size()));
      packet.insert(packet.end(), waiting_.begin(), end);
      waiting_.erase(waiting_.begin(), end);
    } else {
      const Bytes bytes = input_.bytes(count);
      packet.insert(packet.end(), bytes.begin(), bytes.end());
    }
    std::copy(packet.begin(), packet.end(), room);
    *came = how == 254 ? -1 : static_cast<int>(packet.size());
    if (how == 253 && packet.size() == kUsbPacket) *came = 1 << 30;
    if (how != 254 && !writes.empty())
      writes.back().heard.insert(writes.back().heard.end(), packet.begin() + kModem, packet.end());
    return how == 252 ? kTimeout : 0;
  }

  std::vector<Write> writes;

 private:
  static constexpr Byte kUnplugged = 255;

  Byte next() {
    require(!gone_, "a device that is gone is left alone");
    return input_.empty() ? kUnplugged : input_.byte();
  }
  int gone() {
    gone_ = true;
    return kNoDevice;
  }
  /// Answers as a device does.
  void answer(Bytes bytes) {
    constexpr std::array<Byte, 4> kYes = {0x0A, 0x44, 0x2C, 0x0D};
    if (rate_ == kHelloRate) bytes = kYes;
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  }

  Input& input_;
  Sent waiting_;  // bytes that wait for a read
  unsigned rate_ = 0;
  bool gone_ = false;
};

/// Checks that the driver wrote hellos, the first byte of a load, and the pieces of the image in
/// order. The boot loader must have answered the last hello and echoed all but the last write.
void look_at_load(const std::vector<Write>& writes, const Sent& image, bool loaded) {
  const Sent hello = {0x0A, 0x43, 0x0D}, yes = {0x0A, 0x44, 0x2C, 0x0D};
  Sent load = {0x41};
  load.insert(load.end(), image.begin(), image.end());
  std::size_t n = 0, at = 0;
  for (; n < writes.size() && writes[n].rate == kHelloRate; ++n)
    require(!writes[n].whole || writes[n].bytes == hello, "a hello is one");
  require(n <= 100, "hellos end");
  require(n == writes.size() || (n > 0 && writes[n - 1].whole && writes[n - 1].heard == yes),
          "a load begins when the boot loader answers");
  for (; n < writes.size(); ++n) {
    const Write& write = writes[n];
    require(write.rate == kLoadRate && at + write.bytes.size() <= load.size() &&
                std::equal(write.bytes.begin(), write.bytes.end(),
                           load.begin() + static_cast<std::ptrdiff_t>(at)),
            "a piece is of the image");
    require(at > 0 || write.bytes.size() <= 1, "a load begins by its byte");
    at += write.bytes.size();
    const bool echoed = write.whole && write.heard == write.bytes;
    require(echoed || (n + 1 == writes.size() && !loaded), "what is not echoed ends the load");
  }
  require(!loaded || at == load.size(), "an image is loaded to its end");
}

void load(UsbLine& line, Converter& usb, Input& input) {
  Sent image(1U + input.byte());
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<Byte>(i * i + i / 7);
  const std::string wrong = load_firmware(line, image);
  look_at_load(usb.writes, image, wrong.empty());
}

void ask_it(UsbLine& line, Converter& usb, Input& input) {
  const Counts motors = {static_cast<std::int16_t>(input.whole<std::uint16_t>()), 4096, -4096};
  const Packet packet = request(motors, Light::green, false);
  falcon::Answer answer;
  const std::chrono::seconds patience(1);
  const AnswerStatus kind = ask(line, packet, answer, {.send = patience, .answer = patience});
  if (usb.writes.empty())
    return require(kind == AnswerStatus::gone, "without a device there is none");
  require(usb.writes.size() == 1, "one request is sent");
  if (!usb.writes[0].whole) return require(kind == AnswerStatus::unsent, "a short request is none");
  require(std::equal(packet.begin(), packet.end(), usb.writes[0].bytes.begin(),
                     usb.writes[0].bytes.end()),
          "it is sent as it is");
  const Sent& came = usb.writes[0].heard;
  if (kind == AnswerStatus::whole)
    require(came.size() == kPacket && came[0] == '<' &&
                std::equal(came.begin(), came.end(), answer.packet().begin()),
            "an answer is what came");
  if (kind == AnswerStatus::garbled)
    require(came.size() > kPacket || came[0] != '<', "an answer is not called garbled");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  using namespace feltwire::fuzz;
  using Play = void(stand_in::UsbScript*);
  static void* const library = ::dlopen(FELTWIRE_LIBUSB_SCRIPT, RTLD_NOW | RTLD_LOCAL);
  require(library != nullptr, "the scripted libusb is there");
  static auto* const play = reinterpret_cast<Play*>(::dlsym(library, "play_script"));
  static UsbLine line(0x0403, 0xCB48, 0);
  Input input(data, size);
  const bool loads = input.coin();
  Converter usb(input);
  play(&usb);
  if (loads)
    load(line, usb, input);
  else
    ask_it(line, usb, input);
  play(nullptr);
  return 0;
}
