#pragma once
// The two choices that the contact frame leaves open, measured: docs/bounding.md quotes this.

#include <string>

namespace feltwire {

/// `feltwire-lab contact-frame-options`: tables for people.
///   joint or cone      sliding to and fro over dry friction: the remaining normal force
///   minimal or elastic tapping on springs: the force on release, and gliding round a
///                      sphere with delay: how still the hand stays
/// In process and deterministic.
std::string contact_frame_options_tables();

}  // namespace feltwire
