#include "server/app/health.hpp"

#include <asio/ip/address.hpp>
#include <stdexcept>

#include "server/fleet_host/server_answers.hpp"

namespace feltwire {
namespace {

/// Returns the address at which to ask the server: the loopback address of the same family if the
/// server listens on all addresses.
asio::ip::address reachable(const std::string& address) {
  asio::ip::address listening = asio::ip::make_address(address);
  if (!listening.is_unspecified()) return listening;
  if (listening.is_v6()) return asio::ip::address_v6::loopback();
  return asio::ip::address_v4::loopback();
}

}  // namespace

void check_health(const std::string& address, int port, std::chrono::milliseconds timeout) {
  const auto silence = silence_of({reachable(address), static_cast<std::uint16_t>(port)}, timeout);
  if (!silence) return;
  throw std::runtime_error("no feltwire server answers at " + address + " port " +
                           std::to_string(port) + ": " + *silence);
}

}  // namespace feltwire
