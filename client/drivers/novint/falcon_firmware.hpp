#pragma once
// Loads the firmware into a Falcon: it forgets it whenever its power is off.

#include <cstdint>
#include <span>
#include <string>

#include "client/drivers/novint/usb_line.hpp"

namespace feltwire::falcon {

/// The rates and modes in which the firmware talks, with nothing left of before. False: the
/// converter took one of them not.
bool talk_to_firmware(UsbLine& line);

/// Puts the image into the device and lets it start, in one trial. Returns an empty text, or what
/// went wrong: the boot loader gave no answer or another one, an echo differs from what was sent,
/// the device is gone.
std::string load_firmware(UsbLine& line, std::span<const std::uint8_t> image);

}  // namespace feltwire::falcon
