#include "tests/devices/hapi_stand_in.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "tests/devices/scripted.hpp"

namespace stand_in {
namespace {

// [m] lengths of the links, and distance of the shafts
constexpr double kInner = 0.05, kOuter = 0.07, kGap = 0.02;
constexpr double kMiddleX = 0.01, kMiddleY = 0.08;  // [m] origin of the mass
constexpr double kTorqueGain = 0.1;                 // lever of the torque, in inner links
constexpr double kToDegrees = 57.29577951308232, kCounts = 13824.0;
constexpr double kFrameTick = 1e-3;  // [s]

struct Point {
  double x, y;
};

/// Returns the intersection of the circles about both elbows, away from the shafts.
Point forward(double th1, double th2) {
  const Point a{kInner * std::cos(th1), kInner * std::sin(th1)};
  const Point b{kGap + kInner * std::cos(th2), kInner * std::sin(th2)};
  const double d = std::hypot(b.x - a.x, b.y - a.y);
  const double up = std::sqrt(kOuter * kOuter - d * d / 4.0);
  return {(a.x + b.x) / 2.0 - up * (b.y - a.y) / d, (a.y + b.y) / 2.0 + up * (b.x - a.x) / d};
}

/// Returns the angles. The first elbow bends left, and the second bends right.
std::array<double, 2> inverse(Point p) {
  const auto bend = [](double d) {
    return std::acos((kInner * kInner + d * d - kOuter * kOuter) / (2.0 * kInner * d));
  };
  const double d1 = std::hypot(p.x, p.y), d2 = std::hypot(p.x - kGap, p.y);
  return {std::atan2(p.y, p.x) + bend(d1), std::atan2(p.y, p.x - kGap) - bend(d2)};
}

void append(std::vector<std::uint8_t>& bytes, double value) {
  const auto number = static_cast<float>(value);
  std::array<std::uint8_t, 4> four{};
  std::memcpy(four.data(), &number, four.size());
  bytes.insert(bytes.end(), four.begin(), four.end());
}
double number_at(const std::vector<std::uint8_t>& bytes, std::size_t place) {
  float number = 0.0F;
  std::memcpy(&number, bytes.data() + place, sizeof number);
  return static_cast<double>(number);
}

}  // namespace

HapiBoard::HapiBoard() : board_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  mass.position = {0.0, 0.0, 0.004};
  if (board_ < 0 || ::grantpt(board_) != 0 || ::unlockpt(board_) != 0)
    throw std::runtime_error("no pseudo terminal");
  port_ = ::ptsname(board_);
  // The port stays open, so the board gets no hang-up before the driver opens it. Echo is off.
  host_ = ::open(port_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  ::tcgetattr(host_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(host_, TCSANOW, &settings);
}

const std::string& HapiBoard::port() {
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  return port_;
}

HapiBoard::~HapiBoard() {
  stop();
  ::close(host_);
  if (board_ >= 0) ::close(board_);
}

void HapiBoard::stop() {
  over_.store(true);
  if (thread_.joinable()) thread_.join();
}

void HapiBoard::run() {
  std::array<std::uint8_t, 256> room{};
  while (!over_.load()) {
    if (unplug_.load() && board_ >= 0) {
      ::close(board_);
      board_ = -1;
      unplugged.store(true);
    }
    pollfd state{blocks.load() ? -1 : board_, POLLIN, 0};
    if (::poll(&state, 1, 1) <= 0) continue;
    const ssize_t count = ::read(board_, room.data(), room.size());
    if (count > 0) heard_.insert(heard_.end(), room.data(), room.data() + count);
    understand();
  }
}

void HapiBoard::understand() {
  while (heard_.size() >= 2) {
    const unsigned type = heard_[0] >> 4U;
    std::size_t ports = 0;
    for (unsigned bit = 0; bit < 4; ++bit) ports += (heard_[0] >> bit) & 1U;
    const std::size_t size = 2 + (type == 0 ? 8 : 4) * ports;
    if (heard_.size() < size) return;
    if (ports == 2 && !takes_one(loses)) {
      if (type == 0) answer_setup();
      if (type == 1) answer_torques();
    }
    heard_.erase(heard_.begin(), heard_.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

std::array<double, 2> HapiBoard::arms() const {
  return inverse({kMiddleX + mass.position[0], kMiddleY + mass.position[2]});
}

void HapiBoard::answer_setup() {
  if (setups++ == 0) offset.store(number_at(heard_, 2));
  if (firmware == Firmware::silent) return;
  std::vector<std::uint8_t> bytes{heard_[1]};
  if (firmware == Firmware::other_device) bytes[0] ^= 0x40;
  append(bytes, 0.0);
  if (firmware == Firmware::talkative)
    bytes.assign({'e', 'c', 'h', 'o', ':', 's', 't', 'a', 'r', 't'});
  reply(bytes);
}

void HapiBoard::answer_torques() {
  const double t1 = number_at(heard_, 2), t2 = number_at(heard_, 6);
  // The old torque acted until now. The new torque then acts on the mass.
  constexpr double kStep = 1e-6;
  const auto angles = arms();
  const double th1 = std::get<0>(angles), th2 = std::get<1>(angles);
  const auto slope = [&](double d1, double d2) {
    const Point after = forward(th1 + d1, th2 + d2), before = forward(th1 - d1, th2 - d2);
    return Point{(after.x - before.x) / (2.0 * kStep), (after.y - before.y) / (2.0 * kStep)};
  };
  const Point j1 = slope(kStep, 0.0), j2 = slope(0.0, kStep);
  // [N m] j1 . f = t1, j2 . f = t2
  const double m1 = t1 * kInner / kTorqueGain, m2 = t2 * kInner / kTorqueGain;
  const double determinant = j1.x * j2.y - j1.y * j2.x;
  const Point f{(m1 * j2.y - m2 * j1.y) / determinant, (j1.x * m2 - j2.x * m1) / determinant};

  std::vector<std::uint8_t> bytes{heard_[1]};
  for (const double angle : {th1, th2}) {
    const double quantum = 360.0 / kCounts;
    append(bytes, std::round(angle * kToDegrees / quantum) * quantum);
  }
  if (takes_one(not_numbers)) {
    bytes.resize(1);
    append(bytes, std::nan(""));
    append(bytes, 1e30);
  }
  if (takes_one(jumps)) {
    bytes.resize(1);
    append(bytes, th1 * kToDegrees - 40.0);
    append(bytes, th2 * kToDegrees);
  }
  ++frames;
  const double size = std::hypot(f.x, f.y);
  edge.tick();
  edge.command(size > 0.0);
  force.store(size);  // This store is last. A test that sees it may read the other values.
  if (takes_one(late)) std::this_thread::sleep_for(std::chrono::milliseconds(30));
  if (!takes_one(drops)) reply(bytes);
  mass.advance(kFrameTick, {f.x, 0.0, f.y});
}

void HapiBoard::reply(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> out = bytes;
  if (takes_one(garbles)) {
    out.insert(out.begin(), {0xFF, 0x00, 0x13});
    out.resize(7);
  }
  if (takes_one(repeats)) out.insert(out.end(), bytes.begin(), bytes.end());
  [[maybe_unused]] const ssize_t written = ::write(board_, out.data(), out.size());
}

}  // namespace stand_in
