#include "server/scene/prefetched_surfaces.hpp"

#include <string>

namespace feltwire {

/// Counts each live change as a new version for a tool with a body, because its client also fetches
/// the materials and the gravity. For other tools, each patch of a reply has its material.
std::uint32_t prefetched_version(const ToolView& view, std::uint32_t version,
                                 std::uint32_t changes) {
  return view.tool().body != nullptr ? version + changes : version;
}

control::Refused other_version(std::uint32_t version, const std::string& parts) {
  return {control::RefusalCode::bad_scene, "the scene has no version " + std::to_string(version) +
                                               " any more; list its " + parts + " again"};
}

}  // namespace feltwire
