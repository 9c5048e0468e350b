#pragma once
// How the functions of the C interface open a hand.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/c_api/c_call.hpp"
#include "client/c_api/open_hand.hpp"
#include "client/simulator/simulator_session.hpp"

/// The handle of a program.
struct fw_hand : feltwire::Owned<feltwire::OpenHand> {};

namespace feltwire {

/// The wishes of a program for a hand, in a scene of a server or elsewhere. Texts may be null.
struct HandRequest {
  const char* options = "";        // name of the struct that asks, for the texts of errors
  std::vector<std::string> place;  // words of feltwire-client that say where the scene is
  const char* name = nullptr;
  const char* device = nullptr;
  const char* spec = nullptr;
  double duration = 0.0;     // [s]
  double stale_after = 0.0;  // [s]
  const char* const* more = nullptr;
  std::uint32_t more_count = 0;

  /// The fields that all options of hands have.
  template <class Options>
  HandRequest(const char* struct_name, std::vector<std::string> where, const Options& given)
      : options(struct_name),
        place(std::move(where)),
        name(given.name),
        device(given.device),
        spec(given.spec),
        duration(given.duration),
        stale_after(given.stale_after),
        more(given.more),
        more_count(given.more_count) {}
};

/// Opens the device, joins the scene and starts the servo. `simulator`: the program has a simulator
/// in place of a server; null: it has none. Throws std::invalid_argument that names the field, and
/// as OpenHand does.
std::unique_ptr<OpenHand> open_hand(const HandRequest& request,
                                    const SimulatorScene* simulator = nullptr);

}  // namespace feltwire
