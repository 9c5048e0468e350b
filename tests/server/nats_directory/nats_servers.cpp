#include "tests/server/nats_directory/nats_servers.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>

#include "server/access/identity.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::test {
namespace {

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// Ports that were free a moment ago. A cluster's servers must know each other's before they start.
std::vector<int> free_ports(std::size_t count) {
  std::vector<int> sockets, ports;
  for (std::size_t i = 0; i < count; ++i) {
    sockets.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address = local(0);
    socklen_t size = sizeof address;
    if (::bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::getsockname(sockets.back(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no free port");
    ports.push_back(ntohs(address.sin_port));
  }
  for (const int socket : sockets) ::close(socket);
  return ports;
}

void write(const std::string& file, std::string_view text) { std::ofstream(file) << text; }

}  // namespace

NatsServers::NatsServers(int count) : programs_(static_cast<std::size_t>(count)) {
  // Certificates that sign themselves: each side takes the other's for its authority.
  const Identity server = make_identity({"localhost", "127.0.0.1"}), host = make_identity({"host"});
  write(file("server.pem"), server.certificate);
  write(file("server.key"), server.key.text());
  write(file("host.pem"), host.certificate);
  write(file("host.key"), host.key.text());
  const std::vector<int> free = free_ports(2 * programs_.size());
  for (std::size_t i = 0; i < programs_.size(); ++i)
    ports_.push_back({free[2 * i], free[2 * i + 1]});
  for (int i = 0; i < count; ++i) write_configuration(i);
  for (int i = 0; i < count; ++i) start(i);
}

void NatsServers::write_configuration(int server) const {
  const std::string name = "n" + std::to_string(server);
  const Ports& ports = ports_[static_cast<std::size_t>(server)];
  const auto tls = [&](const std::string& authority) {
    return "tls { cert_file: \"" + file("server.pem") + "\", key_file: \"" + file("server.key") +
           "\", ca_file: \"" + file(authority) + "\", verify: true, timeout: 20 }\n";
  };
  std::string text = "server_name: " + name +
                     "\nlisten: \"127.0.0.1:" + std::to_string(ports.clients) + "\"\n" +
                     tls("host.pem") +
                     "authorization { users: [ { user: feltwire, password: secret, permissions: {\n"
                     "  publish: { deny: [\"$JS.API.ACCOUNT.>\", \"$JS.API.SERVER.>\","
                     " \"$JS.API.STREAM.DELETE.>\", \"$JS.API.STREAM.PURGE.>\"] } } } ] }\n"
                     "jetstream { store_dir: \"" +
                     file(name) + "\" }\nlog_file: \"" + file(name + ".log") + "\"\n";
  if (ports_.size() > 1) {
    text += "cluster { name: fleet, listen: \"127.0.0.1:" + std::to_string(ports.cluster) + "\"\n" +
            tls("server.pem") + "  routes: [";
    for (const Ports& other : ports_)
      text += (&other != &ports_.front() ? ", \"" : "\"") + std::string("nats://127.0.0.1:") +
              std::to_string(other.cluster) + "\"";
    text += "] }\n";
  }
  write(file(name + ".conf"), text);
}

NatsOptions NatsServers::options() const {
  NatsOptions options;
  for (const Ports& ports : ports_)
    options.servers.push_back("tls://127.0.0.1:" + std::to_string(ports.clients));
  options.authority = file("server.pem");
  options.certificate = file("host.pem");
  options.key = file("host.key");
  options.user = "feltwire";
  options.password = Secret("secret");
  options.replicas = count();
  options.open = kLongest;
  return options;
}

bool NatsServers::accepts(int server) const {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = local(ports_[static_cast<std::size_t>(server)].clients);
  const bool done =
      ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(socket);
  return done;
}

void NatsServers::kill(int server) { programs_[static_cast<std::size_t>(server)].reset(); }

void NatsServers::start(int server) {
  const std::string configuration = file("n" + std::to_string(server) + ".conf");
  programs_[static_cast<std::size_t>(server)] = std::make_unique<Program>(
      FELTWIRE_NATS_SERVER, std::vector<std::string>{"--config", configuration});
  eventually("a NATS server accepts connections", [&] { return accepts(server); });
}

}  // namespace feltwire::test
