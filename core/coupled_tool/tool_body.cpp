#include "core/coupled_tool/tool_body.hpp"

#include <algorithm>
#include <bit>

namespace feltwire {

std::shared_ptr<const ToolBody> shared(const std::optional<ToolBody>& body) {
  return body ? std::make_shared<const ToolBody>(*body) : nullptr;
}

std::uint32_t body_id(const PointShell& shell, double contact_area) noexcept {
  std::uint64_t sum = 0xcbf29ce484222325;  // FNV-1a, eight bytes at a time
  const auto add = [&sum](double x) {
    sum = (sum ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
    sum ^= sum >> 32;  // else the high bits of a number never reach the low ones of the sum
  };
  for (const Vec3& p : shell.points)
    for (const double x : p) add(x);
  add(shell.area);
  add(contact_area);
  return std::max(std::uint32_t{1}, static_cast<std::uint32_t>(sum));
}

}  // namespace feltwire
