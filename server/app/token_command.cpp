#include "server/app/token_command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "core/base/pending_file.hpp"
#include "core/base/visible_text.hpp"
#include "server/access/json_text.hpp"
#include "server/access/security.hpp"
#include "server/app/fleet_settings.hpp"
#include "server/app/known_scenes.hpp"
#include "server/app/server_config.hpp"
#include "server/app/subcommand.hpp"
#include "server/app/token_places.hpp"

namespace feltwire {
namespace {

constexpr const char* kTokenExamples = R"(
Examples:
  feltwire-server token add --client anna --scene room --role operator --expires 30d
      prints the token only once; send it to its holder over a secure channel
  feltwire-server token list
  feltwire-server token revoke 0123456789ab
      a running server ends the sessions of this token within a second
  feltwire-server token revoke 0123456789ab --fleet nats://n1:4222,n2:4222,n3:4222
      so does every host of the fleet)";

struct TokenArguments {
  std::string client, scene = "*", role, expires, id, out, seat;
  double lead_share = 0.0;
};

void add(const ServerConfig& config, const TokenPlace& place, const TokenArguments& words) {
  const IssuedToken issued =
      issue_token(words.client, words.scene, role(words.role),
                  parse_expiry(words.expires, calendar_now()), words.lead_share, words.seat);
  const std::string_view text = issued.text.text();
  if (const auto warning = unknown_scene(words.scene, known_scenes(config)))
    std::fprintf(stderr, "feltwire-server token: warning: %s\n", visible(*warning).c_str());
  // With --out, write the text of the token before the token is stored: the text exists nowhere
  // else and cannot be recovered.
  std::optional<PendingFile> out;
  if (!words.out.empty()) out.emplace(words.out, text, kPrivate);
  place.add(issued.token);
  if (!out) {
    std::printf("%.*s\n", static_cast<int>(text.size()), text.data());
    return;
  }
  try {
    out->put_in_place();
  } catch (const std::exception&) {
    place.revoke(issued.token.id);
    throw;
  }
}

/// Returns the lead share as text, or "alone" if the hand leads a robot alone.
std::string lead_text(double share) { return share > 0.0 ? json_text::number(share) : "alone"; }

void list(const TokenPlace& place) {
  std::printf("%-12s  %-8s  %-23s  %-20s  %-6s  %s\n", "id", "role", "expires", "client", "lead",
              "scene");
  for (const Token& token : place.list())
    std::printf("%-12s  %-8s  %-23s  %-20s  %-6s  %s%s%s\n", token.id.c_str(),
                name(token.role).data(), expiry_text(token.expires).c_str(),
                visible(token.client).c_str(), lead_text(token.lead_share).c_str(),
                visible(token.scene).c_str(),
                token.seat.empty() ? "" : (", seat " + visible(token.seat)).c_str(),
                expired(token, calendar_now()) ? "  (expired)" : "");
}

void revoke(const TokenPlace& place, const TokenArguments& words) {
  if (!place.revoke(words.id))
    throw std::invalid_argument("there is no token " + words.id + " in " + place.name +
                                "; feltwire-server token list shows which there are");
}

/// Adds the options that say where the tokens are. The server has the same options.
void add_place(CLI::App& command, std::string& config, ServerConfig& given) {
  command.add_option("--config", config, "Configuration file of the server");
  command.add_option("--state", given.state, "State folder of the server")
      ->envname("FELTWIRE_SERVER_STATE");
  command.add_option("--tokens", given.tokens, "Token file of the server")
      ->envname("FELTWIRE_SERVER_TOKENS");
  command.add_option("--fleet", given.fleet,
                     "Directory of a fleet, as the servers' --fleet: the tokens of all its hosts");
}

}  // namespace

int token_command(int argc, char** argv) {
  CLI::App app("Manages the tokens that give clients access", "feltwire-server token");
  app.footer(kTokenExamples);
  app.require_subcommand(1);
  ServerConfig given;
  std::string config_file;
  TokenArguments words;
  CLI::App* adding = app.add_subcommand("add", "Make a token and print it");
  adding->add_option("--client", words.client, "Name of the client that gets the token")
      ->required();
  adding
      ->add_option("--scene", words.scene, "Scene that the token gives access to. '*': every scene")
      ->required();
  adding
      ->add_option("--role", words.role,
                   "Role of the holder: observer, pointer, operator, admin or follower (a robot)")
      ->required();
  adding
      ->add_option(
          "--expires", words.expires,
          "End of the token's validity: 30d, 12h, a date such as 2026-12-31 (UTC), or never")
      ->required();
  adding->add_option("--lead-share", words.lead_share,
                     "Weight of a hand with this token among hands that lead one robot together, "
                     "0.01 to 100. Default: a hand leads alone");
  adding->add_option(
      "--seat", words.seat,
      "Seat of the scene that a robot with this token may take. Default: every seat");
  adding->add_option("--out", words.out,
                     "FILE for the token, in place of stdout. Only its owner can read the file");
  CLI::App* listing = app.add_subcommand("list", "Show all tokens");
  CLI::App* revoking = app.add_subcommand("revoke", "Revoke a token");
  revoking->add_option("ID", words.id, "Id of the token, from feltwire-server token list")
      ->required();
  for (CLI::App* command : {adding, listing, revoking}) add_place(*command, config_file, given);
  return run_subcommand(app, argc, argv, [&] {
    ServerConfig config = config_file.empty() ? given : load_config(config_file);
    if (!given.state.empty()) config.state = given.state;
    if (!given.tokens.empty()) config.tokens = given.tokens;
    if (!given.fleet.empty()) config.fleet = given.fleet;
    const TokenPlace place = given.fleet.empty()
                                 ? file_of_tokens(config)
                                 : fleet_of_tokens(open_fleet_directory(fleet_settings(config)));
    if (adding->parsed() && given.fleet.empty()) make_state_folder(config);
    if (adding->parsed()) add(config, place, words);
    if (listing->parsed()) list(place);
    if (revoking->parsed()) revoke(place, words);
  });
}

}  // namespace feltwire
