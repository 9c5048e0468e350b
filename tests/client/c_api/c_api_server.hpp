#pragma once
// The server that tests of the C interface start, and the way to it.

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/c_api/feltwire.h"
#include "tests/client/floor_server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/security.hpp"

namespace feltwire::c_api_test {

/// A server of this process with one scene, and the files and texts that options of the C interface
/// point to.
struct ApiServer {
  explicit ApiServer(Scene scene = testing::floor_scene(), Tokens tokens = {},
                     double silence_timeout = ServerConfig{}.silence_timeout) {
    std::vector<Scene> scenes;
    scenes.push_back(std::move(scene));
    ServerConfig config = testing::any_ports();
    config.max_sessions_per_client = 32;
    config.silence_timeout = silence_timeout;
    server = std::make_unique<Server>(config, std::move(scenes), test::security(std::move(tokens)));
    address = "127.0.0.1:" + std::to_string(server->control_port());
    token_file = write_token("token", test::admin_token());
    fingerprint = to_string(feltwire::fingerprint(test::identity()));
  }

  std::string write_token(const std::string& name, const IssuedToken& issued) const {
    const std::string file = (folder / name).string();
    std::ofstream(file) << issued.text.text() << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_read);
    return file;
  }

  /// Sets where the server is, and the credentials.
  template <class Options>
  void set_access(Options& options) const {
    options.server = address.c_str();
    options.fingerprint = fingerprint.c_str();
    options.token_file = token_file.c_str();
  }

  fw_hand_options hand_options() const {
    fw_hand_options options;
    fw_hand_options_default(&options, sizeof options);
    set_access(options);
    options.scene = "floor";
    options.more = kMore.data();
    options.more_count = static_cast<std::uint32_t>(kMore.size());
    return options;
  }
  fw_observer_options observer_options() const {
    fw_observer_options options;
    fw_observer_options_default(&options, sizeof options);
    set_access(options);
    options.scene = "floor";
    return options;
  }
  fw_admin_options admin_options() const {
    fw_admin_options options;
    fw_admin_options_default(&options, sizeof options);
    set_access(options);
    return options;
  }

  // A busy machine may let the thread of a test wait.
  static constexpr std::array<const char*, 4> kMore = {"--flight-recorder", "off", "--let-go-after",
                                                       "1"};
  testing::TemporaryFolder folder;
  std::unique_ptr<Server> server;
  std::string address, token_file, fingerprint;
};

}  // namespace feltwire::c_api_test
