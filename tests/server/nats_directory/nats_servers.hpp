#pragma once
// Real NATS servers of a test: on free ports of this machine, with mutual TLS, a user, and their
// files in a folder that is removed afterwards.

#include <memory>
#include <string>
#include <vector>

#include "server/nats_directory/nats_directory.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::test {

class NatsServers {
 public:
  /// Starts them, and waits until they accept connections.
  explicit NatsServers(int count);

  /// The options that a host of the fleet is given.
  NatsOptions options() const;
  void kill(int server);
  /// Starts a server that was killed, on the same ports and files.
  void start(int server);
  /// The number of the server with this name.
  static int number(const std::string& name) { return std::stoi(name.substr(1)); }
  int count() const { return static_cast<int>(ports_.size()); }

 private:
  struct Ports {
    int clients = 0, cluster = 0;
  };
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  void write_configuration(int server) const;
  bool accepts(int server) const;

  TemporaryFolder folder_;
  std::vector<Ports> ports_;
  std::vector<std::unique_ptr<Program>> programs_;
};

}  // namespace feltwire::test
