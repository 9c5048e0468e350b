#include "tests/fuzz/libusb_script.hpp"

#include <sys/types.h>

#include <cstring>

namespace {

using Byte = std::uint8_t;

stand_in::UsbScript* script = nullptr;
int context_marker, device_marker, handle_marker;
void* list_of_devices[2] = {&device_marker, nullptr};

}  // namespace

extern "C" {

void play_script(stand_in::UsbScript* played) { script = played; }

int libusb_init(void** context) { return *context = &context_marker, 0; }
void libusb_exit(void*) {}
ssize_t libusb_get_device_list(void*, void*** list) { return *list = list_of_devices, 1; }
void libusb_free_device_list(void**, int) {}
int libusb_get_device_descriptor(void*, void* into) {
  // Length, type, USB 2.0, class, subclass, protocol, packet, vendor 0403, product cb48, and so on.
  constexpr Byte kAbout[18] = {18, 1, 0, 2, 0, 0, 0, 8, 0x03, 0x04, 0x48, 0xCB, 0, 6, 1, 2, 3, 1};
  return std::memcpy(into, kAbout, sizeof kAbout), 0;
}
int libusb_open(void*, void** handle) { return *handle = &handle_marker, 0; }
void libusb_close(void*) {}
int libusb_claim_interface(void*, int) { return 0; }
int libusb_release_interface(void*, int) { return 0; }
int libusb_control_transfer(void*, Byte, Byte what, std::uint16_t value, std::uint16_t, Byte*,
                            std::uint16_t, unsigned) {
  return script->control(what, value);
}
int libusb_bulk_transfer(void*, Byte endpoint, Byte* data, int length, int* transferred, unsigned) {
  if (endpoint == 0x02) return script->write(data, length, transferred);
  return script->read(data, length, transferred);
}
const char* libusb_error_name(int) { return "LIBUSB_ERROR"; }
}
