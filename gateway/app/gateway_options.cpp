#include "gateway/app/gateway_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <stdexcept>

#include "client/command_line/credential_options.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "server/access/security.hpp"
#include "server/app/server_config.hpp"

namespace feltwire {
namespace {

constexpr const char* kExamples = R"(
Example, with access to the server's state folder and scene files:
  feltwire-view --connect localhost:6720 --scene scenes/room.json --web 6761
      --fingerprint-file ~/.local/state/feltwire/fingerprint --token-file observer.token
The program prints the address of the page:
  live page: http://127.0.0.1:6761/
Stop it with Ctrl-C or SIGTERM. SIGHUP reloads the scene files and the certificate.
Environment variables also set options: FELTWIRE_VIEW_LOG_LEVEL sets --log-level.)";

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
                 "Scene file (JSON) of a scene of the server. The names of file and scene must be "
                 "equal. Repeat the option for several scenes")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--web", config.web,
                 "PORT or ADDRESS:PORT of the page. PORT alone serves this machine. ADDRESS:PORT "
                 "also serves other machines, by HTTPS. 0: a free port")
      ->capture_default_str();
  app.add_option("--web-name", config.web_names,
                 "Host name that browsers may use for the page, in addition to IP addresses and "
                 "localhost. Repeat the option for several names")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--log-format", config.log_format, "text, or json: one object a line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_option("--log-level", config.log_level, "trace, debug, info, warning, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  const auto group = "Viewers of this page";
  app.add_option("--state", config.state,
                 "Folder of the page's certificate, its key and the tokens. The program creates "
                 "missing files. Default: `view` in feltwire's state folder")
      ->group(group);
  app.add_option("--certificate", config.certificate,
                 "FILE (PEM) of the page's certificate. Default: from --state")
      ->group(group);
  app.add_option("--key", config.key, "FILE (PEM) of the key of --certificate")->group(group);
  app.add_option("--tokens", config.tokens, "FILE of the tokens. Default: from --state")
      ->group(group);
}

/// Reads the file of --config. Its files lie in its folder. Throws std::invalid_argument, as for a
/// wrong command line.
ConfigFile view_config(const CLI::App& app, int argc, const char* const* argv) {
  const FileValue files =
      files_in_folder({"ca", "certificate", "client-certificate", "client-key", "fingerprint-file",
                       "key", "scene", "state", "token-file", "tokens"});
  return given_config(app, argc, argv, {}, files, {}, true);
}

void check(const GatewayConfig& config) {
  if (config.certificate.empty() != config.key.empty())
    throw std::invalid_argument("--certificate and --key belong together; give both, or neither");
  if (const auto wrong = wrong_web_name(config.web_names))
    throw std::invalid_argument("--web-name: " + *wrong);
}

}  // namespace

GatewayConfig gateway_config(int argc, char** argv) {
  CLI::App app(
      "feltwire-view: serves the live page of a server that runs on another machine. It joins as "
      "an observer.",
      "feltwire-view");
  app.footer(kExamples);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-view"); },
      "Print version, commit, compiler and build type, and exit");
  GatewayConfig config;
  std::string endpoint, config_file;
  CredentialOptions words;
  app.add_option("--config", config_file,
                 "FILE.json with options: {\"scenes\": [\"room.json\"], \"web\": 6761}. The "
                 "command line and the environment override it (docs/live_page.md)");
  add_page(app, config);
  add_server(app, endpoint, words);
  read_environment(app, argc, argv, {.program = "view", .shared = credential_variables("client-")},
                   credential_rivals());
  const ConfigFile file = view_config(app, argc, argv);
  try {
    parse_words(app, words_with_config(app, argc, argv, file, credential_rivals(), true));
    check(config);
    config.server = {parse_endpoint(endpoint), credentials(words)};
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(app.exit(error));  // for example after --help
    throw std::invalid_argument((file.entries.empty() ? error.what() : file.located(error.what())) +
                                advice(error, app) + " (see --help)");
  } catch (const std::invalid_argument& error) {
    if (file.entries.empty()) throw;
    throw std::invalid_argument(file.located(error.what()));
  }
  if (config.state.empty() && (config.certificate.empty() || config.tokens.empty()))
    config.state = default_state_folder() / "view";
  return config;
}

}  // namespace feltwire
