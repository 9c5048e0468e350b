// Takes arbitrary bytes from a service on this machine. The result must be no message, or a message
// with possible numbers. The driver must be able to write a command for such a message.

#include "client/drivers/haply/haply_messages.hpp"

#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

using namespace feltwire::haply;

void look_at(const Message& message, std::string_view text) {
  const HaplyState& told = message.told;
  require(message.devices > 0 && !told.id.empty(), "a message is of a device");
  require(told.position.value_or(Vec3::Zero()).allFinite() &&
              told.force.value_or(Vec3::Zero()).allFinite() && told.mount.allFinite() &&
              told.scale.allFinite() && std::isfinite(told.damping),
          "numbers are finite");
  require(!message.orientation || std::abs(message.orientation->norm() - 1.0) < 1e-9,
          "an orientation is one");
  // The name must select the device.
  const auto again = read_message(text, told.id);
  require(again && again->told.id == told.id && again->dialect == message.dialect,
          "a device is found by its id");
  if (told.id.size() > kMostId) return;
  std::array<char, kMostCommand> command{};
  for (const bool first : {false, true}) {
    const std::size_t size =
        write_command(message.dialect, told.id, Vec3(-10.0, 1e-7, 10.0), first, command);
    require(size < command.size() && command[size - 1] == '}', "a command has room");
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string text = fuzz::text(data, size);
  if (const auto message = haply::read_message(text, "")) fuzz::look_at(*message, text);
  return 0;
}
