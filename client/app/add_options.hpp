#pragma once
// The options of feltwire-client, each with its help and the value that it sets.

#include "client/app/client_options.hpp"
#include "client/app/option_values.hpp"

namespace CLI {
class App;
}

namespace feltwire {

/// Adds every option but --help and --version. `values` and `options` outlive `app`.
void add_options(CLI::App& app, OptionValues& values, ClientOptions& options);

}  // namespace feltwire
