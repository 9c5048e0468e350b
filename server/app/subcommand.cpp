#include "server/app/subcommand.hpp"

#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/base/visible_text.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {

int run_subcommand(CLI::App& app, int argc, char** argv, const std::function<void()>& work) {
  const auto fail = [&app](const std::string& why, const char* remedy, int status) {
    std::fprintf(stderr, "%s: %s%s\n", app.get_name().c_str(), printable_error(why).c_str(),
                 remedy);
    return status;
  };
  try {
    parse_arguments(app, argc, argv);
    work();
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return fail(error.what() + advice(error, app), " (see --help)", kBadUsage);
  } catch (const std::invalid_argument& error) {
    return fail(error.what(), "", kBadUsage);
  } catch (const std::exception& error) {
    return fail(error.what(), "", kCannotRun);
  }
}

}  // namespace feltwire
