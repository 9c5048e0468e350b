#include "client/input_devices/usb_scan.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <system_error>

#include "client/input_devices/input_nodes.hpp"
#include "client/input_devices/machine_files.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

struct Known {
  std::string_view vendor, product;  // an empty product matches any product
  std::string_view what, kind;
};
// USB identifiers that other users have reported.
constexpr std::array kKnown = {
    Known{"1451", "", "Force Dimension", "forcedimension"},
    Known{"0403", "cb48", "Novint Falcon", "falcon"},
    Known{"0301", "2988", "Touch", "openhaptics"},
    Known{"2988", "0302", "Touch", "openhaptics"},
    Known{"16c0", "0483", "Haply Inverse3, or another board with a Teensy", "haply"},
    Known{"2fe3", "0100", "Haply VerseGrip's receiver", "haply"},
};

/// Converts "4" to "004", as in the folder names of /dev/bus/usb. Returns an empty text if `number`
/// is invalid.
std::string three_digits(const std::string& number) {
  const auto digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  if (number.empty() || number.size() > 3 || !std::all_of(number.begin(), number.end(), digit))
    return {};
  return std::string(3 - number.size(), '0') + number;
}

/// Returns the device files (nodes) of a USB device, of its serial ports and of its HID interfaces.
std::vector<fs::path> nodes_of(const fs::path& device) {
  std::vector<fs::path> nodes;
  const std::string bus = three_digits(line_of(device / "busnum"));
  const std::string number = three_digits(line_of(device / "devnum"));
  if (!bus.empty() && !number.empty()) nodes.push_back(fs::path("/dev/bus/usb") / bus / number);
  const std::string interfaces = device.filename().string() + ":";
  for (const fs::path& interface : entries(device)) {
    if (!interface.filename().string().starts_with(interfaces)) continue;
    for (const fs::path& port : entries(interface / "tty"))
      nodes.push_back("/dev" / port.filename());
    for (const fs::path& hid : entries(interface))
      for (const fs::path& raw : entries(hid / "hidraw")) nodes.push_back("/dev" / raw.filename());
  }
  return nodes;
}

/// Returns a text such as "ModemManager (process 812)". It lists each other process that has the
/// node open.
std::string holders(const fs::path& root, const fs::path& node) {
  std::string list;
  for (const fs::path& process : entries(root / "proc")) {
    const std::string number = process.filename().string();
    if (!std::isdigit(static_cast<unsigned char>(number.front()))) continue;
    if (number == std::to_string(::getpid())) continue;
    for (const fs::path& open : entries(process / "fd")) {
      std::error_code none;
      if (fs::read_symlink(open, none) != node) continue;
      list.append(list.empty() ? "" : ", ")
          .append(line_of(process / "comm") + " (process " + number + ")");
      break;
    }
  }
  return list;
}

/// Adds a complaint to `device` if the node is missing, or if this program may not open it.
void check_node(const Machine& machine, const fs::path& node, int rights, const std::string& rule,
                ConnectedDevice& device) {
  const fs::path file = machine.root / node.relative_path();
  std::error_code none;
  if (!fs::exists(file, none)) {
    device.complaints.push_back({node.string() + " is not there",
                                 "plug it in anew; in a container, pass the node on to it"});
    return;
  }
  const bool may = machine.may_open ? machine.may_open(file) : ::access(file.c_str(), rights) == 0;
  if (!may) device.complaints.push_back({"you may not open " + node.string(), rule_to_paste(rule)});
}

void examine(const Machine& machine, const Known& known, const std::string& product,
             ConnectedDevice& device) {
  const std::string rule = "SUBSYSTEMS==\"usb\", ATTRS{idVendor}==\"" + std::string(known.vendor) +
                           "\", ATTRS{idProduct}==\"" + product + "\", TAG+=\"uaccess\"";
  for (const fs::path& node : device.nodes) {
    check_node(machine, node, R_OK | W_OK, rule, device);
    const std::string held = holders(machine.root, node);
    if (held.empty()) continue;
    const bool modem = held.find("ModemManager") != std::string::npos;
    device.complaints.push_back(
        {node.string() + " is held by " + held,
         modem ? "write into /etc/udev/rules.d/70-feltwire.rules the line  ATTRS{idVendor}==\"" +
                     std::string(known.vendor) +
                     "\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"  and plug it in anew"
               : std::string("end that program, where it is not the maker's own service")});
  }
  if (device.kind.empty())
    device.complaints.push_back(
        {"feltwire has no driver for it yet",
         "write a plugin (docs/devices.md#as-a-plugin-in-c---device-pluginfilesoarguments)"});
}

/// Returns an input device and its problems. Other readers are no problem, because many programs
/// may read an event node.
ConnectedDevice examined(const Machine& machine, const InputNode& node) {
  ConnectedDevice device{node.vendor + ":" + node.product,
                         (node.kind == "gamepad" ? "Gamepad" : "3D mouse") +
                             (node.name.empty() ? std::string() : ", \"" + node.name + "\""),
                         std::string(node.kind),
                         {node.node},
                         {}};
  check_node(machine, node.node, R_OK, input_rule(node.vendor, node.product), device);
  const std::string held = holders(machine.root, node.node);
  if (held.find("spacenavd") != std::string::npos)
    device.complaints.push_back({node.node.string() + " is held by " + held,
                                 "stop it while feltwire runs: sudo systemctl stop spacenavd"});
  return device;
}

}  // namespace

std::vector<ConnectedDevice> scan_usb(const Machine& machine) {
  std::vector<ConnectedDevice> found;
  for (const fs::path& device : entries(machine.root / "sys/bus/usb/devices")) {
    const std::string vendor = line_of(device / "idVendor"),
                      product = line_of(device / "idProduct");
    const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& one) {
      return one.vendor == vendor && (one.product.empty() || one.product == product);
    });
    if (known == kKnown.end()) continue;
    const std::string own = line_of(device / "product");
    ConnectedDevice one{vendor + ":" + product,
                        std::string(known->what) + (own.empty() ? "" : ", \"" + own + "\""),
                        std::string(known->kind),
                        nodes_of(device),
                        {}};
    examine(machine, *known, product, one);
    found.push_back(std::move(one));
  }
  for (const InputNode& node : input_nodes(machine)) found.push_back(examined(machine, node));
  return found;
}

std::string text(const std::vector<ConnectedDevice>& devices) {
  if (devices.empty())
    return "no haptic device that feltwire knows is on USB, and no gamepad or 3D mouse at an event "
           "node; is it plugged in and switched on? One on Ethernet is not seen here.\n";
  std::string lines;
  for (const ConnectedDevice& device : devices) {
    lines += device.what + " (" + device.id + ")";
    for (const fs::path& node : device.nodes) lines += ", " + node.string();
    lines += "\n";
    if (!device.kind.empty()) lines += "  --device " + device.kind + "\n";
    for (const Complaint& complaint : device.complaints)
      lines += "  problem: " + complaint.problem + "\n  remedy: " + complaint.remedy + "\n";
  }
  return lines;
}

}  // namespace feltwire
