#include "client/input_devices/event_node.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "client/input_devices/input_nodes.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_node(const fs::path& node, int error) {
  std::string remedy = "check the name; feltwire-client devices lists what is plugged in";
  if (error == EACCES) remedy = input_node_remedy(Machine{}, node);
  throw std::runtime_error("cannot open " + node.string() + ": " +
                           std::generic_category().message(error) + "; " + remedy);
}

/// Bits in the kernel's layout: machine words, lowest bits first.
template <std::size_t Count>
struct Bits {
  static constexpr std::size_t kPerWord = sizeof(unsigned long) * CHAR_BIT;
  std::array<unsigned long, (Count + kPerWord - 1) / kPerWord> words{};
  std::bitset<Count> set() const noexcept {
    std::bitset<Count> bits;
    for (std::size_t n = 0; n < Count; ++n)
      bits[n] = ((words[n / kPerWord] >> (n % kPerWord)) & 1UL) != 0;
    return bits;
  }
};

}  // namespace

EventNode::EventNode(const fs::path& node)
    : descriptor_(::open(node.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)),
      control_([](int descriptor, unsigned long request, void* room) {
        return ::ioctl(descriptor, request, room);
      }) {
  if (descriptor_ < 0) refuse_node(node, errno);
  try {
    take();
  } catch (const std::runtime_error& error) {
    ::close(descriptor_);
    throw std::runtime_error(node.string() + ": " + error.what());
  }
}

EventNode::EventNode(int descriptor, Control control)
    : descriptor_(descriptor), control_(std::move(control)) {
  try {
    take();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

EventNode::EventNode(EventNode&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), control_(std::move(other.control_)) {}

EventNode::~EventNode() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void EventNode::take() {
  int version = 0;
  if (control_(descriptor_, EVIOCGVERSION, &version) != 0)
    throw std::runtime_error(
        "it is no event node of the kernel; name one, as event5 or /dev/input/event5");
  // EVIOCGRAB takes its argument as a number, not as an address.
  if (control_(descriptor_, EVIOCGRAB, reinterpret_cast<void*>(1)) == 0) return;
  if (errno == EBUSY)
    throw std::runtime_error(
        "another program has it for itself, as spacenavd does; end that program "
        "(feltwire-client devices says who holds it)");
  throw std::runtime_error("the kernel does not let this program use it alone: " +
                           std::generic_category().message(errno) + "; plug it in anew");
}

std::optional<std::size_t> EventNode::read(std::span<input_event> room) const noexcept {
  const ssize_t count = ::read(descriptor_, room.data(), room.size_bytes());
  if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
  // The kernel returns only whole events, so any other size is an error.
  if (count <= 0 || count % static_cast<ssize_t>(sizeof(input_event)) != 0) return std::nullopt;
  return static_cast<std::size_t>(count) / sizeof(input_event);
}

std::optional<input_absinfo> EventNode::axis(unsigned code) const noexcept {
  input_absinfo info{};
  if (control_(descriptor_, EVIOCGABS(code), &info) < 0) return std::nullopt;
  return info;
}

std::optional<InputKeys> EventNode::pressed() const noexcept {
  Bits<KEY_CNT> bits;
  if (control_(descriptor_, EVIOCGKEY(sizeof bits.words), bits.words.data()) < 0)
    return std::nullopt;
  return bits.set();
}

InputKeys EventNode::keys() const noexcept {
  Bits<KEY_CNT> bits;
  control_(descriptor_, EVIOCGBIT(EV_KEY, sizeof bits.words), bits.words.data());
  return bits.set();
}

InputAxes EventNode::axes() const noexcept {
  Bits<ABS_CNT> bits;
  control_(descriptor_, EVIOCGBIT(EV_ABS, sizeof bits.words), bits.words.data());
  return bits.set();
}

InputAxes EventNode::relative_axes() const noexcept {
  Bits<ABS_CNT> bits;  // large enough for the relative axes, because REL_CNT is smaller
  control_(descriptor_, EVIOCGBIT(EV_REL, sizeof bits.words), bits.words.data());
  return bits.set();
}

}  // namespace feltwire
