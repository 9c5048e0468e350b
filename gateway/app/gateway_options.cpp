#include "gateway/app/gateway_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <stdexcept>

#include "client/command_line/credential_options.hpp"
#include "core/build_info/build_info.hpp"
#include "core/command_line/environment.hpp"
#include "core/command_line/suggestion.hpp"
#include "server/access/security.hpp"

namespace feltwire {
namespace {

constexpr const char* kExamples = R"(
Example, where the server's state folder and scenes are at hand:
  feltwire-view --connect localhost:6720 --scene scenes/room.json --web 6761
      --fingerprint-file ~/.local/state/feltwire/fingerprint --token-file observer.token
A line says where the page is:
  live page: http://127.0.0.1:6761/
End it with Ctrl-C or SIGTERM. SIGHUP reads the scenes' files anew.
Every option may come from the environment, --log-level from FELTWIRE_VIEW_LOG_LEVEL.)";

void add_server(CLI::App& app, std::string& endpoint, CredentialOptions& words) {
  const auto group = "The observed server (SECURITY.md)";
  app.add_option("--connect", endpoint,
                 "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required()
      ->group(group);
  add_credential_options(
      app, words, {.group = group, .token = "a token of the role observer", .prefix = "client-"});
}

void add_page(CLI::App& app, GatewayConfig& config) {
  app.add_option("--scene", config.scenes,
                 "Scene file (JSON) of a scene of the server, to draw it; it must have the "
                 "scene's name. Repeat the option for several scenes")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--web", config.web,
                 "PORT of the page, for this machine alone. ADDRESS:PORT: for other machines too, "
                 "by HTTPS. 0: a free port")
      ->capture_default_str();
  app.add_option("--web-name", config.web_names,
                 "Host name that browsers may use for the page, besides IP addresses and "
                 "localhost. Repeat the option for several names")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--log-level", config.log_level, "trace, debug, info, warning, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  const auto group = "Viewers of this page";
  app.add_option(
         "--state", config.state,
         "Folder of the page's certificate, its key and the tokens. Missing ones are created. "
         "When not given: `view` in feltwire's state folder")
      ->group(group);
  app.add_option("--certificate", config.certificate,
                 "FILE (PEM) of the certificate, instead of the state folder's")
      ->group(group);
  app.add_option("--key", config.key, "FILE (PEM) of the certificate's key")->group(group);
  app.add_option("--tokens", config.tokens, "FILE of the tokens, instead of the state folder's")
      ->group(group);
}

}  // namespace

GatewayConfig gateway_config(int argc, char** argv) {
  CLI::App app("Serves the live page of a server on another machine, as its observer.",
               "feltwire-view");
  app.footer(kExamples);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-view"); },
      "Print version, commit, compiler and kind of build");
  GatewayConfig config;
  std::string endpoint;
  CredentialOptions words;
  add_page(app, config);
  add_server(app, endpoint, words);
  read_environment(app, argc, argv, {.program = "view", .shared = credential_variables("client-")},
                   credential_rivals());
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(app.exit(error));  // This is the case for --help.
    throw std::invalid_argument(error.what() + advice(error, app) + " (see --help)");
  }
  if (config.certificate.empty() != config.key.empty())
    throw std::invalid_argument("--certificate and --key belong together; give both, or neither");
  config.server = {parse_endpoint(endpoint), credentials(words)};
  if (config.state.empty() && (config.certificate.empty() || config.tokens.empty()))
    config.state = default_state_folder() / "view";
  return config;
}

}  // namespace feltwire
