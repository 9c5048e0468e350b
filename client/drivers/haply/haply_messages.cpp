#include "client/drivers/haply/haply_messages.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <system_error>
#include <utility>

namespace feltwire::haply {
namespace {

constexpr int kDeepest = 32;
constexpr double kLargest = 1e6;  // largest valid absolute value of a number
constexpr std::string_view kBlanks = " \t\r\n";

/// Parses JSON from left to right. Reads nothing after an error.
class Scanner {
 public:
  explicit Scanner(std::string_view text) noexcept : rest_(text) {}

  bool good() const noexcept { return good_; }
  bool at_end() noexcept { return peek() == '\0' && rest_.empty(); }
  /// Returns the next character after blanks, or zero at the end.
  char peek() noexcept {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    return rest_.empty() ? '\0' : rest_.front();
  }

  /// Reads an object. Calls take(key) for each member; take() must read the value.
  template <class Take>
  void object(Take take) noexcept {
    list('{', '}', [&] {
      const std::string_view key = string();
      expect(':');
      if (good_) take(key);
    });
  }
  /// Reads an array. Calls take() for each element; take() must read the element.
  template <class Take>
  void array(Take take) noexcept {
    list('[', ']', take);
  }
  /// Returns the raw text between the quotes.
  std::string_view string() noexcept {
    if (!expect('"')) return {};
    for (std::size_t n = 0; n < rest_.size(); ++n) {
      if (static_cast<unsigned char>(rest_[n]) < ' ') break;
      if (rest_[n] == '\\') {
        ++n;
      } else if (rest_[n] == '"') {
        const std::string_view text = rest_.substr(0, n);
        rest_.remove_prefix(n + 1);
        return text;
      }
    }
    good_ = false;
    return {};
  }
  double number() noexcept {
    peek();
    double value = 0.0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    good_ &= error == std::errc() && std::abs(value) <= kLargest;
    if (good_) rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return good_ ? value : 0.0;
  }
  bool boolean() noexcept {
    const bool value = peek() == 't';
    word(value ? "true" : "false");
    return value && good_;
  }
  /// Skips any JSON value.
  void skip() noexcept {
    switch (peek()) {
      case '{':
        return object([this](std::string_view) { skip(); });
      case '[':
        return array([this] { skip(); });
      case '"':
        string();
        return;
      case 't':
        return word("true");
      case 'f':
        return word("false");
      case 'n':
        return word("null");
      default:
        number();
    }
  }

 private:
  bool expect(char c) noexcept {
    good_ = good_ && peek() == c;
    if (good_) rest_.remove_prefix(1);
    return good_;
  }
  void word(std::string_view text) noexcept {
    good_ &= rest_.starts_with(text);
    if (good_) rest_.remove_prefix(text.size());
  }
  template <class Take>
  void list(char opens, char closes, Take take) noexcept {
    expect(opens);
    good_ &= ++depth_ <= kDeepest;
    bool first = true;
    while (good_ && peek() != closes) {
      if (!first) expect(',');
      first = false;
      if (good_) take();
    }
    expect(closes);
    --depth_;
  }

  std::string_view rest_;
  int depth_ = 0;
  bool good_ = true;
};

/// Reads {"x": 1, "y": 2, "z": 3}. A missing member leaves this component of `value` unchanged.
Vec3 vector(Scanner& scan, Vec3 value) noexcept {
  scan.object([&](std::string_view key) {
    const std::size_t axis = key.size() == 1 ? std::string_view("xyz").find(key) : 3;
    if (axis < 3)
      value[static_cast<Eigen::Index>(axis)] = scan.number();
    else
      scan.skip();
  });
  return value;
}

/// Reads {"w": 1, "x": 0, "y": 0, "z": 0}. Returns nothing unless the length is 1.
std::optional<Quaternion> orientation(Scanner& scan) noexcept {
  constexpr double kRounding = 1e-2;  // tolerance of the quaternion's length
  Eigen::Vector4d value = Eigen::Vector4d::Zero();
  scan.object([&](std::string_view key) {
    const std::size_t at = key.size() == 1 ? std::string_view("xyzw").find(key) : 4;
    if (at < 4)
      value[static_cast<Eigen::Index>(at)] = scan.number();
    else
      scan.skip();
  });
  const double length = value.norm();
  if (!(std::abs(length - 1.0) < kRounding)) return std::nullopt;  // also refuses NaN
  return Quaternion(Eigen::Vector4d(value / length));
}

/// Reads a quaternion. Returns whether it rotates: a component x, y or z exceeds 1e-6.
bool turns(Scanner& scan) noexcept {
  bool turned = false;
  scan.object([&](std::string_view key) {
    if (key == "w")
      scan.number();
    else
      turned |= std::abs(scan.number()) > 1e-6;
  });
  return turned;
}

void read_state(Scanner& scan, HaplyState& told) noexcept {
  scan.object([&](std::string_view key) {
    if (key == "cursor_position")
      told.position = vector(scan, Vec3::Constant(std::nan("")));
    else if (key == "current_cursor_force")
      told.force = vector(scan, Vec3::Constant(std::nan("")));
    else
      scan.skip();
  });
  // Accept a vector only if all components are valid.
  if (told.position && !told.position->allFinite()) told.position.reset();
  if (told.force && !told.force->allFinite()) told.force.reset();
}

void read_filters(Scanner& scan, HaplyState& told) noexcept {
  const auto value_of = [&](std::string_view name, auto take) {
    scan.object([&](std::string_view key) {
      if (key == name)
        take(scan.number());
      else
        scan.skip();
    });
  };
  scan.object([&](std::string_view key) {
    if (key == "damping")
      value_of("scalar", [&](double d) { told.damping = d; });
    else if (key == "force_gate")
      value_of("gain", [&](double g) { told.gate = g; });
    else
      scan.skip();
  });
}

void read_config(Scanner& scan, HaplyState& told, bool& session) noexcept {
  scan.object([&](std::string_view key) {
    if (key == "filters") {
      session = true;
      read_filters(scan, told);
    } else if (key == "basis") {
      scan.object([&](std::string_view name) {
        if (name == "permutation")
          told.permutation = scan.string();
        else
          scan.skip();
      });
    } else if (key == "mount") {
      scan.object([&](std::string_view name) {
        if (name == "position")
          told.mount = vector(scan, told.mount);
        else if (name == "scale")
          told.scale = vector(scan, told.scale);
        else if (name == "rotation")
          told.turned = turns(scan);
        else
          scan.skip();
      });
    } else if (key == "gravity_compensation") {
      scan.object([&](std::string_view name) {
        if (name == "enabled")
          told.compensates_gravity = scan.boolean();
        else
          scan.skip();
      });
    } else if (key == "handedness" && scan.peek() == '"') {
      told.left_handed = scan.string().starts_with("left");
    } else {
      scan.skip();
    }
  });
}

void read_status(Scanner& scan, HaplyState& told) noexcept {
  const std::pair<std::string_view, std::optional<bool>*> all[] = {{"calibrated", &told.calibrated},
                                                                   {"ready", &told.ready},
                                                                   {"power_supply", &told.powered},
                                                                   {"in_use", &told.in_use}};
  scan.object([&](std::string_view name) {
    const char begins = scan.peek();
    const auto* one = std::ranges::find(all, name, [](const auto& entry) { return entry.first; });
    if (one != std::end(all) && (begins == 't' || begins == 'f'))
      *one->second = scan.boolean();
    else
      scan.skip();
  });
}

HaplyState read_device(Scanner& scan, std::string_view id, bool& session) noexcept {
  HaplyState told;
  told.id = id;
  scan.object([&](std::string_view key) {
    if (key == "device_id") {
      told.id = scan.string();
    } else if (key == "state") {
      read_state(scan, told);
    } else if (key == "config") {
      read_config(scan, told, session);
    } else if (key == "status") {
      read_status(scan, told);
    } else {
      scan.skip();
    }
  });
  return told;
}

struct Grip {
  std::optional<std::array<bool, 3>> buttons;
  std::optional<Quaternion> orientation;
};

/// Reads the "state" of a grip: "buttons": {"a": true, ...} or "button": true, and "orientation".
Grip read_grip(Scanner& scan) noexcept {
  Grip grip;
  std::optional<std::array<bool, 3>>& buttons = grip.buttons;
  scan.object([&](std::string_view key) {
    if (key != "state") return scan.skip();
    scan.object([&](std::string_view name) {
      if (name == "button") {
        buttons = {scan.boolean(), false, false};
      } else if (name == "buttons") {
        buttons.emplace();
        scan.object([&](std::string_view button) {
          const std::size_t n = button.size() == 1 ? std::string_view("abc").find(button) : 3;
          if (n < 3)
            (*buttons)[n] = scan.boolean();
          else
            scan.skip();
        });
      } else if (name == "orientation" && scan.peek() == '{') {
        grip.orientation = orientation(scan);
      } else {
        scan.skip();
      }
    });
  });
  return grip;
}

/// Appends text to a fixed buffer.
struct Writer {
  std::span<char> room;
  std::size_t size = 0;

  void put(std::string_view text) noexcept {
    const std::size_t count = std::min(text.size(), room.size() - size);
    std::copy_n(text.begin(), count, room.begin() + static_cast<std::ptrdiff_t>(size));
    size += count;
  }
  void put(double value) noexcept {
    std::array<char, 32> digits{};
    const auto end =
        std::to_chars(digits.begin(), digits.end(), value, std::chars_format::fixed, 6);
    put({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  }
};

}  // namespace

bool HaplyState::neutral() const noexcept {
  constexpr double kNeutral = 1e-6;  // tolerance of the mount [m], the damping [N s/m] and a scale
  return permutation == "XYZ" && mount.isZero(kNeutral) && scale.isOnes(kNeutral) && !turned &&
         std::abs(damping) <= kNeutral;
}

bool lists_devices(std::string_view text) noexcept {
  Scanner scan(text);
  bool lists = false;
  scan.object([&](std::string_view key) {
    lists |= key == "inverse3";
    scan.skip();
  });
  return scan.good() && lists;
}

std::optional<Message> read_message(std::string_view text, std::string_view id) noexcept {
  Scanner scan(text);
  Message message;
  bool session = false, keyed = false, found = false;
  const auto device = [&](std::string_view key) {
    const HaplyState told = read_device(scan, key, session);
    ++message.devices;
    if (found || told.id.empty() || !(id.empty() || told.id == id)) return;
    found = true;
    message.told = told;
  };
  const auto grip = [&] {
    const Grip told = read_grip(scan);
    if (!message.buttons) message.buttons = told.buttons;
    if (!message.orientation) message.orientation = told.orientation;
  };
  scan.object([&](std::string_view key) {
    if (key == "session_id") {
      session = true;
      scan.skip();
    } else if (key == "inverse3" && scan.peek() == '{') {
      keyed = true;
      scan.object(device);
    } else if (key == "inverse3") {
      scan.array([&] { device({}); });
    } else if ((key == "verse_grip" || key == "wireless_verse_grip") && scan.peek() == '[') {
      scan.array(grip);
    } else {
      scan.skip();
    }
  });
  if (!scan.good() || !scan.at_end() || !found) return std::nullopt;
  message.dialect = keyed ? Dialect::keyed : session ? Dialect::session : Dialect::values;
  return message;
}

std::size_t write_command(Dialect dialect, std::string_view id, const Vec3& force, bool first,
                          std::span<char, kMostCommand> text) noexcept {
  Writer writer{text};
  const bool names = first && dialect == Dialect::session;
  writer.put("{");
  if (names) writer.put(R"("session":{"configure":{"profile":{"name":"feltwire"}}},)");
  writer.put(R"("inverse3":[{"device_id":")");
  writer.put(id);
  writer.put("\",");
  if (names) writer.put(R"("configure":{"damping":{"scalar":0.0}},)");
  writer.put(R"("commands":{"set_cursor_force":{")");
  writer.put(dialect == Dialect::session ? "vector" : "values");
  writer.put(R"(":{"x":)");
  writer.put(force.x());
  writer.put(R"(,"y":)");
  writer.put(force.y());
  writer.put(R"(,"z":)");
  writer.put(force.z());
  writer.put("}}}}]}");
  return writer.size;
}

}  // namespace feltwire::haply
