#include "client/followers/follower_lines.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/base/number_list.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire::follower_lines {
namespace {

constexpr std::string_view kFinite = "is no finite number; write one like 0.25";
constexpr double kMost = 1e6;  // a larger number is invalid

/// Returns the text before the next blank. Removes this text and the blank from `rest`.
std::string_view word(std::string_view& rest) noexcept {
  const std::size_t end = std::min(rest.find(' '), rest.size());
  const std::string_view text = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return text;
}

bool read(std::string_view text, Vec3& v) noexcept {
  return numbers_of(text, std::span<double>(v.data(), 3), kMost);
}

std::string_view read(std::string_view text, Pose& pose) noexcept {
  std::array<double, 7> v{};
  if (!numbers_of(text, v, kMost)) return "is no seven finite numbers; write X,Y,Z,QW,QX,QY,QZ";
  const Vec3 position(v[0], v[1], v[2]);
  const Quaternion turned(v[3], v[4], v[5], v[6]);
  if (position.cwiseAbs().maxCoeff() > kMaxPosition) return "is farther than 1000 m; use metres";
  if (std::abs(turned.squaredNorm() - 1.0) > kUnitTolerance)
    return "has an orientation that is no unit quaternion; write QW,QX,QY,QZ of length 1";
  pose = {position, turned.normalized()};
  return {};
}

std::string_view read_flag(std::string_view text, bool& flag) noexcept {
  if (text != "0" && text != "1") return "is neither 0 nor 1";
  flag = text == "1";
  return {};
}

std::string_view read_positive(std::string_view text, double& value, bool zero) noexcept {
  const auto given = number_of(text, kMost);
  if (!given) return kFinite;
  if (*given < 0.0 || (*given == 0.0 && !zero))
    return zero ? "is negative; give 0 or more" : "is not above 0";
  value = *given;
  return {};
}

/// Calls take(name, value) for each field NAME=VALUE of `rest`. take() returns an error text, or an
/// empty text. Returns the first error, or nothing.
template <class Take>
std::optional<Fault> each_field(std::string_view rest, Take take) {
  while (!rest.empty()) {
    const std::string_view field = word(rest);
    const std::size_t sign = field.find('=');
    if (sign == std::string_view::npos) return Fault{field, "is no field; write NAME=VALUE"};
    const std::string_view name = field.substr(0, sign);
    if (const std::string_view wrong = take(name, field.substr(sign + 1)); !wrong.empty())
      return Fault{name, wrong};
  }
  return std::nullopt;
}

/// Sets the bit of a field in `seen`. Returns false if it was set before, so the line has the field
/// twice.
bool first_time(unsigned& seen, unsigned bit) noexcept {
  if ((seen & bit) != 0) return false;
  seen |= bit;
  return true;
}
constexpr std::string_view kTwice = "stands twice; write it once";
constexpr std::string_view kUnknown = "is no field of this line; docs/followers.md lists them";

std::string_view read_name(std::string_view text, std::string& name) {
  constexpr std::size_t kLongest = 64;
  const bool plain = std::ranges::all_of(text, [](char c) { return c > ' ' && c <= '~'; });
  if (text.empty() || text.size() > kLongest || !plain)
    return "is no name; use 1 to 64 letters, digits and signs without blanks";
  name = text;
  return {};
}

class Writer {
 public:
  explicit Writer(std::span<char> room) : room_(room) {}
  void put(std::string_view text) noexcept {
    fits_ = fits_ && at_ + text.size() <= room_.size();
    if (!fits_) return;
    std::memcpy(room_.data() + at_, text.data(), text.size());
    at_ += text.size();
  }
  template <class Number>
  void put_number(Number value) noexcept {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    fits_ = fits_ && error == std::errc();
    put({digits.data(), static_cast<std::size_t>(end - digits.data())});
  }
  std::size_t size() const noexcept { return fits_ ? at_ : 0; }

 private:
  std::span<char> room_;
  std::size_t at_ = 0;
  bool fits_ = true;
};

/// Compares a field of a line with the allowed fields, one call for each. Each call uses the next
/// bit of `seen`, so the calls must always come in the same order.
class KnownFields {
 public:
  KnownFields(std::string_view name, unsigned& seen) : name_(name), seen_(seen) {}

  template <class Read>
  void operator()(std::string_view known, Read read_it) {
    if (name_ == known) wrong_ = first_time(seen_, bit_) ? read_it() : kTwice;
    bit_ *= 2;
  }
  /// Returns the error text of the field, or an empty text.
  std::string_view wrong() const { return wrong_; }

 private:
  std::string_view name_;
  unsigned& seen_;
  unsigned bit_ = 1;
  std::string_view wrong_ = kUnknown;
};

}  // namespace

std::optional<Fault> read_hello(std::string_view line, FollowerSpec& spec) {
  std::string_view rest = line;
  if (word(rest) != "follower")
    return Fault{"follower", "is not the first word; begin with \"follower 1 name=...\""};
  if (word(rest) != "1") return Fault{"follower", "is of another version; this is version 1"};
  FollowerSpec given;
  given.name.clear();
  given.stiffness = 0.0;
  unsigned seen = 0;
  const auto fault = each_field(rest, [&](std::string_view name, std::string_view value) {
    KnownFields take(name, seen);
    take("name", [&] { return read_name(value, given.name); });
    take("period", [&] { return read_positive(value, given.servo_period, false); });
    take("stiffness", [&] { return read_positive(value, given.stiffness, false); });
    take("damping", [&] { return read_positive(value, given.damping, true); });
    take("own_damping", [&] { return read_positive(value, given.own_damping, true); });
    take("mass", [&] { return read_positive(value, given.mass, true); });
    take("senses_wrench", [&] { return read_flag(value, given.senses_wrench); });
    take("wrench_noise", [&] { return read_positive(value, given.wrench_noise, true); });
    take("gripper", [&] { return read_positive(value, given.gripper_opening, true); });
    return take.wrong();
  });
  if (fault) return fault;
  constexpr double kShortest = 1e-4, kLongest = 0.05;  // [s] range of the servo period
  if (given.name.empty()) return Fault{"name", "is missing; add name=NAME"};
  if (given.stiffness <= 0.0) return Fault{"stiffness", "is missing; add stiffness=N_PER_M"};
  if ((seen & 2u) == 0) return Fault{"period", "is missing; add period=SECONDS"};
  if (given.servo_period < kShortest || given.servo_period > kLongest)
    return Fault{"period", "is not between 0.0001 and 0.05 s; send 20 states a second or more"};
  spec = std::move(given);
  return std::nullopt;
}

std::optional<Fault> read_state(std::string_view line, std::uint64_t& number,
                                FollowerReading& reading) noexcept {
  std::string_view rest = line;
  if (word(rest) != "state") return Fault{"state", "is not the first word; write \"state N ...\""};
  const std::string_view digits = word(rest);
  std::uint64_t counted = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), counted);
  if (error != std::errc() || end != digits.data() + digits.size())
    return Fault{"state", "has no number; write \"state N ...\" with N = 1, 2, ..."};
  FollowerReading given;
  unsigned seen = 0;
  const auto fault = each_field(rest, [&](std::string_view name, std::string_view value) {
    KnownFields take(name, seen);
    const auto vector = [&](Vec3& v) {
      return read(value, v) ? std::string_view()
                            : std::string_view("is no three finite numbers; write X,Y,Z");
    };
    take("pose", [&] { return read(value, given.pose); });
    take("commanded", [&] { return read(value, given.commanded); });
    take("velocity", [&] { return vector(given.velocity); });
    take("turning", [&] { return vector(given.angular_velocity); });
    take("force", [&] { return vector(given.force.emplace()); });
    take("torque", [&] { return vector(given.torque); });
    take("gripper", [&] { return read_positive(value, given.gripper, true); });
    take("grip", [&] { return read_positive(value, given.gripper_force, true); });
    take("ok", [&] { return read_flag(value, given.ok); });
    take("stopped", [&] { return read_flag(value, given.stopped); });
    return take.wrong();
  });
  if (fault) return fault;
  if ((seen & 1u) == 0) return Fault{"pose", "is missing; add pose=X,Y,Z,QW,QX,QY,QZ"};
  if ((seen & 2u) == 0) return Fault{"commanded", "is missing; add the pose of the held target"};
  number = counted;
  reading = given;
  return std::nullopt;
}

std::size_t write_target(std::uint64_t number, const FollowerTarget& target,
                         std::span<char> line) noexcept {
  Writer writer(line);
  const Quaternion& q = target.pose.orientation;
  writer.put("target ");
  writer.put_number(number);
  writer.put(" pose=");
  const Vec3& p = target.pose.position;
  bool first = true;
  for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
    if (!first) writer.put(",");
    writer.put_number(value);
    first = false;
  }
  writer.put(" gripper=");
  writer.put_number(target.gripper);
  writer.put("\n");
  return writer.size();
}

std::span<char> Lines::room() noexcept {
  if (begin_ > 0) {
    std::memmove(bytes_.data(), bytes_.data() + begin_, filled_ - begin_);
    filled_ -= begin_;
    begin_ = 0;
  }
  return std::span<char>(bytes_).subspan(filled_);
}

std::optional<Lines::Line> Lines::next() noexcept {
  for (;;) {
    const std::string_view rest(bytes_.data() + begin_, filled_ - begin_);
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) {
      if (rest.size() < kLongestLine) return std::nullopt;
      const bool more = skipping_;  // whether this line was already returned as too long
      skipping_ = true;
      begin_ = filled_;
      if (more) return std::nullopt;
      return Line{++count_, rest.substr(0, kLongestLine), true};
    }
    std::string_view text = rest.substr(0, end);
    begin_ += end + 1;
    if (skipping_) {
      skipping_ = false;
      continue;
    }
    ++count_;
    if (text.size() >= kLongestLine) return Line{count_, text.substr(0, kLongestLine), true};
    if (text.ends_with('\r')) text.remove_suffix(1);
    if (!text.empty()) return Line{count_, text, false};
  }
}

}  // namespace feltwire::follower_lines
