#include "client/followers/socket_follower.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace feltwire {
namespace {

using follower_lines::Fault;

std::string reason() { return std::generic_category().message(errno); }

/// Writes "error LINE: FIELD: WHAT\n" into `text`. Returns the length.
std::size_t write_error(std::uint64_t line, const Fault& fault, std::span<char> text) noexcept {
  std::size_t size = 0;
  const auto put = [&](std::string_view part) {
    const std::size_t count = std::min(part.size(), text.size() - 1 - size);
    // Replace unprintable characters, because the text can come from the driver.
    std::transform(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count),
                   text.begin() + static_cast<std::ptrdiff_t>(size),
                   [](char c) { return c >= ' ' && c <= '~' ? c : '?'; });
    size += count;
  };
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), line).ptr;
  constexpr std::size_t kLongestField = 64;
  put("error ");
  put({digits.data(), static_cast<std::size_t>(end - digits.data())});
  put(": ");
  put(fault.field.substr(0, kLongestField));
  put(": ");
  put(fault.what);
  text[size++] = '\n';
  return size;
}

constexpr Fault kTooLong{"line", "is longer than 1023 bytes; end each line with a line feed"};

OwnDescriptor listen_at(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path.string();
  if (name.empty() || name.size() >= sizeof address.sun_path)
    throw std::runtime_error("the driver's socket '" + name + "' is not 1 to " +
                             std::to_string(sizeof address.sun_path - 1) +
                             " bytes long; give a shorter path");
  std::memcpy(address.sun_path, name.data(), name.size());
  struct stat status {};
  if (::lstat(name.c_str(), &status) == 0) {
    if (!S_ISSOCK(status.st_mode))
      throw std::runtime_error(name +
                               ": is there and is no socket; remove it or give another path");
    ::unlink(name.c_str());
  }
  OwnDescriptor made(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (made.get() < 0) throw std::runtime_error(name + ": cannot make a socket: " + reason());
  // Nobody can connect before listen(). So the permissions exclude all other users from the start.
  constexpr mode_t kOwner = S_IRUSR | S_IWUSR;
  if (::bind(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(name.c_str(), kOwner) != 0 || ::listen(made.get(), 1) != 0)
    throw std::runtime_error(name + ": cannot wait for a driver there: " + reason() +
                             "; give a path in a folder that you may write to");
  return made;
}

}  // namespace

OwnDescriptor::~OwnDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

SocketFollower::SocketFollower(OwnDescriptor socket, FollowerSpec spec,
                               const follower_lines::Lines& rest)
    : socket_(std::move(socket)), spec_(std::move(spec)), lines_(rest) {}

FollowerReading SocketFollower::read(Nanoseconds now) noexcept {
  receive(now);
  if (hold_.load() && !hold_said_) hold_said_ = send("hold\n", 5);
  flush();
  return robot_.read(now, connected_);
}

void SocketFollower::receive(Nanoseconds now) noexcept {
  constexpr int kMostReads = 16;
  int faults = 0;
  for (int i = 0; i < kMostReads; ++i) {
    while (const auto line = lines_.next())
      if (!take(*line, now, faults < kMostAnswers) && ++faults == kMostFaults) return;
    const std::span<char> room = lines_.room();
    const ssize_t count = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (count == 0) connected_ = false;
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) connected_ = false;
    if (count <= 0) return;
    lines_.added(static_cast<std::size_t>(count));
  }
}

bool SocketFollower::take(const follower_lines::Lines::Line& line, Nanoseconds now,
                          bool answers) noexcept {
  std::uint64_t number = 0;
  FollowerReading state;
  auto fault = line.too_long ? std::optional<Fault>(kTooLong)
                             : follower_lines::read_state(line.text, number, state);
  if (!fault && robot_.has_reported() && number <= newest_)
    fault = Fault{"state", "has a number that is not above the last one; count upwards"};
  if (!fault) {
    robot_.report(state, now);
    newest_ = number;
    return true;
  }
  ++faults_;
  if (!answers) return false;
  std::array<char, 256> text{};
  send(text.data(), write_error(line.number, *fault, text));
  return false;
}

FollowerTarget SocketFollower::write(const FollowerTarget& target) noexcept {
  FollowerTarget held = robot_.write(target, hold_.load());
  if (!robot_.has_reported() || hold_.load()) return held;
  std::array<char, follower_lines::kLongestLine> line{};
  send(line.data(), follower_lines::write_target(++sent_, held, line));
  return held;
}

void SocketFollower::hold() noexcept {
  hold_.store(true);
  // Send immediately, because read() and write() may not run again. The first line feed ends a
  // partly sent line.
  constexpr std::string_view kNow = "\nhold\n";
  [[maybe_unused]] const ssize_t sent =
      ::send(socket_.get(), kNow.data(), kNow.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

/// Sends the rest of a partly sent line. Returns true if nothing remains.
bool SocketFollower::flush() noexcept {
  if (pending_size_ == 0) return true;
  const ssize_t count =
      ::send(socket_.get(), pending_.data(), pending_size_, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count <= 0) return false;
  pending_size_ -= static_cast<std::size_t>(count);
  std::memmove(pending_.data(), pending_.data() + count, pending_size_);
  return pending_size_ == 0;
}

/// Sends a line. If the buffer is full, drops the line and returns false, because the next target
/// is newer.
bool SocketFollower::send(const char* text, std::size_t size) noexcept {
  if (size == 0 || !connected_ || !flush()) return false;
  const ssize_t count = ::send(socket_.get(), text, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count <= 0) return false;
  pending_size_ = size - static_cast<std::size_t>(count);
  std::memcpy(pending_.data(), text + count, pending_size_);
  return true;
}

FollowerListener::FollowerListener(std::filesystem::path path)
    : path_(std::move(path)), socket_(listen_at(path_)) {}

FollowerListener::~FollowerListener() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::unique_ptr<SocketFollower> FollowerListener::wait(Nanoseconds longest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  const auto ready = [&](int descriptor) {
    using std::chrono::milliseconds;
    const auto left = std::chrono::ceil<milliseconds>(end - std::chrono::steady_clock::now());
    pollfd waits{descriptor, POLLIN, 0};
    constexpr auto kLongestPoll = milliseconds(std::chrono::hours(1));
    const int time = static_cast<int>(std::clamp(left, milliseconds(0), kLongestPoll).count());
    int found = 0;
    do found = ::poll(&waits, 1, time);
    while (found < 0 && errno == EINTR);
    return found > 0;
  };
  if (!ready(socket_.get()))
    throw std::runtime_error(path_.string() +
                             ": no driver came; start one that connects to this socket");
  OwnDescriptor driver(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (driver.get() < 0)
    throw std::runtime_error(path_.string() + ": the driver is gone: " + reason());
  // Request the smallest send buffer that the kernel allows, so that old targets do not wait for a
  // slow driver.
  const int least = 1;
  ::setsockopt(driver.get(), SOL_SOCKET, SO_SNDBUF, &least, sizeof least);
  follower_lines::Lines lines;
  std::size_t read = 0;
  for (;;) {
    if (const auto line = lines.next()) {
      FollowerSpec spec;
      const auto fault = line->too_long ? std::optional<Fault>(kTooLong)
                                        : follower_lines::read_hello(line->text, spec);
      std::array<char, 256> text{};
      const std::size_t size = fault ? write_error(line->number, *fault, text) : 0;
      if (fault) {
        ::send(driver.get(), text.data(), size, MSG_NOSIGNAL);
        throw std::runtime_error(path_.string() +
                                 ": the driver's hello: " + std::string(text.data(), size - 1));
      }
      constexpr std::string_view kWelcome = "welcome 1\n";
      ::send(driver.get(), kWelcome.data(), kWelcome.size(), MSG_NOSIGNAL);
      return std::make_unique<SocketFollower>(std::move(driver), std::move(spec), lines);
    }
    const std::span<char> room = lines.room();
    const ssize_t count =
        ready(driver.get()) ? ::recv(driver.get(), room.data(), room.size(), 0) : -1;
    if (count <= 0)
      throw std::runtime_error(path_.string() +
                               ": the driver said no hello; its first line is \"follower 1 ...\"");
    read += static_cast<std::size_t>(count);
    if (read > kMostBeforeHello)
      throw std::runtime_error(path_.string() + ": the driver said no hello in " +
                               std::to_string(kMostBeforeHello) +
                               " bytes; its first line is \"follower 1 ...\"");
    lines.added(static_cast<std::size_t>(count));
  }
}

}  // namespace feltwire
