#include "client/drivers/novint/usb_line.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <vector>

namespace feltwire {
namespace {

// Constants from the documentation of libusb-1.0. Its API is stable since 2008.
constexpr int kAccess = -3, kNoDevice = -4, kBusy = -6, kTimeout = -7;
constexpr std::uint8_t kToDevice = 0x40;  // type of a vendor request to the device
constexpr unsigned char kBulkOut = 0x02, kBulkIn = 0x81;
constexpr int kInterface = 0;
constexpr std::size_t kPacketBytes = 64, kModemBytes = 2;
constexpr unsigned kControlPatience = 1000;  // [ms] timeout of a control transfer

struct Descriptor {
  std::uint8_t length, type;
  std::uint16_t usb;
  std::uint8_t device_class, subclass, protocol, packet;
  std::uint16_t vendor, product, device;
  std::uint8_t manufacturer_text, product_text, serial_text, configurations;
};
static_assert(sizeof(Descriptor) == 18);

struct Version {
  std::uint16_t major, minor, micro, nano;
  const char *rc, *description;
};

/// Returns the timeout [ms]. It is at least 1, because libusb takes 0 as no timeout.
unsigned milliseconds_of(Nanoseconds patience) {
  return static_cast<unsigned>(std::max<std::int64_t>(
      1, std::chrono::duration_cast<std::chrono::milliseconds>(patience).count()));
}

}  // namespace

struct UsbLine::Calls {
  explicit Calls(SharedLibrary loaded)
      : library(std::move(loaded)),
        init(library.get<int(void**)>("libusb_init")),
        exit(library.get<void(void*)>("libusb_exit")),
        list(library.get<ssize_t(void*, void***)>("libusb_get_device_list")),
        free_list(library.get<void(void**, int)>("libusb_free_device_list")),
        descriptor(library.get<int(void*, Descriptor*)>("libusb_get_device_descriptor")),
        open(library.get<int(void*, void**)>("libusb_open")),
        close(library.get<void(void*)>("libusb_close")),
        claim(library.get<int(void*, int)>("libusb_claim_interface")),
        release(library.get<int(void*, int)>("libusb_release_interface")),
        detach(library.find<int(void*, int)>("libusb_set_auto_detach_kernel_driver")),
        control(
            library.get<int(void*, std::uint8_t, std::uint8_t, std::uint16_t, std::uint16_t,
                            unsigned char*, std::uint16_t, unsigned)>("libusb_control_transfer")),
        bulk(library.get<int(void*, unsigned char, unsigned char*, int, int*, unsigned)>(
            "libusb_bulk_transfer")),
        error_name(library.get<const char*(int)>("libusb_error_name")),
        version(library.find<const Version*()>("libusb_get_version")) {}

  SharedLibrary library;
  int (*init)(void**);
  void (*exit)(void*);
  ssize_t (*list)(void*, void***);
  void (*free_list)(void**, int);
  int (*descriptor)(void*, Descriptor*);
  int (*open)(void*, void**);
  void (*close)(void*);
  int (*claim)(void*, int);
  int (*release)(void*, int);
  int (*detach)(void*, int);  // null if the library lacks it
  int (*control)(void*, std::uint8_t, std::uint8_t, std::uint16_t, std::uint16_t, unsigned char*,
                 std::uint16_t, unsigned);
  int (*bulk)(void*, unsigned char, unsigned char*, int, int*, unsigned);
  const char* (*error_name)(int);
  const Version* (*version)();  // null if the library lacks it
};

std::unique_ptr<UsbLine::Calls> UsbLine::load() {
  const std::vector<std::filesystem::path> files = {"libusb-1.0.so.0", "libusb-1.0.so"};
  try {
    return std::make_unique<Calls>(SharedLibrary::first_of(files));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("libusb cannot be used: ") + error.what() +
                             "; install libusb-1.0-0");
  }
}

UsbLine::UsbLine(std::uint16_t vendor, std::uint16_t product, int number) : call_(load()) {
  if (const int error = call_->init(&context_); error != 0)
    throw std::runtime_error(std::string("libusb does not start: ") + call_->error_name(error));
  try {
    open(vendor, product, number);
  } catch (...) {
    close();
    throw;
  }
}

UsbLine::~UsbLine() { close(); }

void UsbLine::close() noexcept {
  if (device_ != nullptr) {
    call_->release(device_, kInterface);
    call_->close(device_);
  }
  call_->exit(context_);
}

void UsbLine::open(std::uint16_t vendor, std::uint16_t product, int number) {
  void** devices = nullptr;
  const ssize_t count = call_->list(context_, &devices);
  if (count < 0)
    throw std::runtime_error(std::string("libusb lists no devices: ") +
                             call_->error_name(static_cast<int>(count)));
  int found = 0, error = kNoDevice;
  for (ssize_t i = 0; i < count; ++i) {
    Descriptor about{};
    if (call_->descriptor(devices[i], &about) != 0) continue;
    if (about.vendor != vendor || about.product != product || found++ != number) continue;
    error = call_->open(devices[i], &device_);
    if (error != 0) device_ = nullptr;
  }
  call_->free_list(devices, 1);
  if (found <= number)
    throw std::runtime_error(
        found == 0 ? std::string("no such device is on USB; plug it in and switch its power on")
                   : "there are only " + std::to_string(found) + " of them, counted from 0");
  if (error == kAccess)
    throw std::runtime_error(
        "you may not open it; feltwire-client devices prints the udev rule to paste");
  if (error != 0)
    throw std::runtime_error(std::string("it cannot be opened: ") + call_->error_name(error));
  if (call_->detach != nullptr) call_->detach(device_, 1);
  error = call_->claim(device_, kInterface);
  if (error == 0) return;
  call_->close(device_);
  device_ = nullptr;
  throw std::runtime_error(error == kBusy
                               ? std::string("another program has it; end that")
                               : std::string("it cannot be claimed: ") + call_->error_name(error));
}

bool UsbLine::control(Request request, std::uint16_t value) {
  return call_->control(device_, kToDevice, static_cast<std::uint8_t>(request), value, kInterface,
                        nullptr, 0, kControlPatience) >= 0;
}

std::optional<std::size_t> UsbLine::write(std::span<const std::uint8_t> bytes,
                                          Nanoseconds patience) {
  int sent = 0;
  // The cast is safe, because libusb does not modify sent data.
  auto* const data = const_cast<unsigned char*>(bytes.data());
  const int error = call_->bulk(device_, kBulkOut, data, static_cast<int>(bytes.size()), &sent,
                                milliseconds_of(patience));
  if (error != 0 && error != kTimeout) return std::nullopt;
  return static_cast<std::size_t>(std::max(sent, 0));
}

std::optional<std::size_t> UsbLine::read(std::span<std::uint8_t> room, Nanoseconds patience) {
  std::array<unsigned char, kPacketBytes> packet{};
  int came = 0;
  const int error = call_->bulk(device_, kBulkIn, packet.data(), static_cast<int>(packet.size()),
                                &came, milliseconds_of(patience));
  if (error != 0 && error != kTimeout) return std::nullopt;
  const auto size = static_cast<std::size_t>(std::clamp(came, 0, int{kPacketBytes}));
  if (size <= kModemBytes) return 0;
  const std::size_t count = std::min(size - kModemBytes, room.size());
  std::copy_n(packet.begin() + kModemBytes, count, room.begin());
  return count;
}

std::string UsbLine::library() {
  const std::unique_ptr<Calls> call = load();
  std::string text = call->library.loaded_from().string();
  if (call->version == nullptr) return text;
  const Version& v = *call->version();
  return text + ", version " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." +
         std::to_string(v.micro);
}

}  // namespace feltwire
