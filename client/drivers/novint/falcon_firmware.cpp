#include "client/drivers/novint/falcon_firmware.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "protocol/net/clock.hpp"

namespace feltwire::falcon {
namespace {

using Request = UsbLine::Request;
using std::chrono::milliseconds;

constexpr std::uint16_t kPurgeReceived = 1, kPurgeSent = 2;
// [ms] Latency timer of the serial converter, slow and fast.
constexpr std::uint16_t kSlowLatency = 16, kFastLatency = 1;
// Divisors of the converter's clock for 9600, 140 000 and about 1.4 million bits per second.
constexpr std::uint16_t kHelloRate = 0x4138, kLoadRate = 0x15, kTalkRate = 0x02;
constexpr std::uint16_t kEightBits = 8, kNoFlow = 0;
constexpr std::uint16_t kRtsLow = 0x0200, kDtrLow = 0x0100, kDtrHigh = 0x0101;
constexpr int kHellos = 100;
// [bytes] Data in a USB packet of 64 bytes. The converter adds two bytes.
constexpr std::size_t kPiece = 62;
constexpr Nanoseconds kEchoPatience = milliseconds(1000), kHelloPatience = milliseconds(50);

const char* const kGone = "the device is gone, or does not take what is sent; plug it in anew";

bool purge(UsbLine& line) {
  return line.control(Request::reset, kPurgeReceived) && line.control(Request::reset, kPurgeSent);
}

/// Returns `count` received bytes, or fewer after `patience`. Returns nothing if the device is
/// unplugged.
std::optional<std::vector<std::uint8_t>> heard(UsbLine& line, std::size_t count,
                                               Nanoseconds patience) {
  const Nanoseconds latest = monotonic_now() + patience;
  std::vector<std::uint8_t> all;
  std::array<std::uint8_t, kPiece> room{};
  while (all.size() < count) {
    const Nanoseconds left = latest - monotonic_now();
    if (left.count() <= 0) break;
    const auto came = line.read(room, left);
    if (!came) return std::nullopt;
    all.insert(all.end(), room.begin(), room.begin() + static_cast<std::ptrdiff_t>(*came));
  }
  return all;
}

enum class Echo : std::uint8_t { right, wrong, gone };

Echo says(UsbLine& line, std::span<const std::uint8_t> bytes,
          std::span<const std::uint8_t> expected, Nanoseconds patience) {
  const auto sent = line.write(bytes, patience);
  if (!sent) return Echo::gone;
  if (*sent != bytes.size()) return Echo::wrong;
  const auto answer = heard(line, expected.size(), patience);
  if (!answer) return Echo::gone;
  return std::equal(answer->begin(), answer->end(), expected.begin(), expected.end()) ? Echo::right
                                                                                      : Echo::wrong;
}

/// Wakes the boot loader with a hello message, and prepares it for a firmware. Returns the error,
/// or an empty text.
std::string wake_boot_loader(UsbLine& line) {
  constexpr std::array<std::uint8_t, 3> kHello = {0x0A, 0x43, 0x0D};
  constexpr std::array<std::uint8_t, 4> kYes = {0x0A, 0x44, 0x2C, 0x0D};
  constexpr std::array<std::uint8_t, 1> kLoad = {0x41};
  const bool ready =
      purge(line) && line.control(Request::latency, kSlowLatency) &&
      line.control(Request::baud, kHelloRate) && line.control(Request::data, kEightBits) &&
      line.control(Request::flow, kNoFlow) && line.control(Request::modem, kRtsLow) &&
      line.control(Request::modem, kDtrLow) && line.control(Request::modem, kDtrHigh);
  if (!ready) return kGone;
  Echo echo = Echo::wrong;
  for (int n = 0; n < kHellos && echo == Echo::wrong; ++n)
    echo = says(line, kHello, kYes, kHelloPatience);
  if (echo == Echo::gone) return kGone;
  if (echo == Echo::wrong)
    return "its boot loader does not answer; switch its power off and on, and plug it into a port "
           "of the machine itself";
  if (!line.control(Request::modem, kDtrLow) || !line.control(Request::baud, kLoadRate))
    return kGone;
  echo = says(line, kLoad, kLoad, kEchoPatience);
  if (echo == Echo::gone) return kGone;
  return echo == Echo::right ? ""
                             : "its boot loader takes no firmware; switch its power off and on";
}

}  // namespace

bool talk_to_firmware(UsbLine& line) {
  return line.control(Request::latency, kFastLatency) && line.control(Request::baud, kTalkRate) &&
         purge(line);
}

std::string load_firmware(UsbLine& line, std::span<const std::uint8_t> image) {
  if (std::string wrong = wake_boot_loader(line); !wrong.empty()) return wrong;
  for (std::size_t at = 0; at < image.size(); at += kPiece) {
    const auto piece = image.subspan(at, std::min(kPiece, image.size() - at));
    switch (says(line, piece, piece, kEchoPatience)) {
      case Echo::gone:
        return kGone;
      case Echo::wrong:
        return "the echo of the firmware at byte " + std::to_string(at) +
               " is not what was sent; plug it into a port of the machine itself";
      case Echo::right:
        break;
    }
  }
  return talk_to_firmware(line) ? "" : kGone;
}

}  // namespace feltwire::falcon
