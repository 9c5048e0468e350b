#pragma once
// Opens the device as the hand gets it, and the way to the scene.

#include <functional>
#include <memory>

#include "client/app/client_options.hpp"

namespace feltwire {

/// Puts the protection of the hand and the mapping of the workspace around an opened device. Sets
/// the emergency stop and the true energy of the options. Throws std::invalid_argument with the
/// option's name and the remedy.
std::unique_ptr<Device> hand_device(OpenedDevice opened, ClientOptions& options);

/// Returns RunOptions::open_port: a UDP port, behind an emulated link if the options have one.
std::function<std::unique_ptr<DatagramPort>(const Address& scene)> port_opener(
    const ClientOptions& options);

}  // namespace feltwire
