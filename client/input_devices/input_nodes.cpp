#include "client/input_devices/input_nodes.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <climits>
#include <sstream>

#include "client/input_devices/machine_files.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

/// Returns the bits of a line in /sys: hexadecimal words, the highest word first, without leading
/// zeros. Returns no bits for any other line.
template <std::size_t Count>
std::bitset<Count> bits_of(const std::string& line) {
  constexpr std::size_t kPerWord = sizeof(unsigned long) * CHAR_BIT;
  std::vector<unsigned long> words;
  std::istringstream text(line);
  for (std::string word; text >> word;) {
    unsigned long value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, 16);
    if (error != std::errc() || end != word.data() + word.size()) return {};
    words.push_back(value);
  }
  std::bitset<Count> bits;
  for (std::size_t n = 0; n < std::min(Count, words.size() * kPerWord); ++n)
    bits[n] = ((words[words.size() - 1 - n / kPerWord] >> (n % kPerWord)) & 1UL) != 0;
  return bits;
}

/// Returns the number in a name such as "event5", or nothing for other names.
std::optional<unsigned> event_number(const fs::path& path) {
  constexpr std::string_view kEvent = "event";
  const std::string name = path.filename().string();
  if (!name.starts_with(kEvent)) return std::nullopt;
  unsigned number = 0;
  const char* const end = name.data() + name.size();
  const auto [last, error] = std::from_chars(name.data() + kEvent.size(), end, number);
  if (error != std::errc() || last != end) return std::nullopt;
  return number;
}

}  // namespace

std::string_view input_kind(const InputKeys& keys, const InputAxes& axes,
                            const InputAxes& relative_axes) noexcept {
  const auto all = [](const InputAxes& has, unsigned first, unsigned last) {
    for (unsigned code = first; code <= last; ++code)
      if (!has[code]) return false;
    return true;
  };
  if (keys[BTN_SOUTH]) return all(axes, ABS_X, ABS_Y) ? "gamepad" : "";
  const bool six = all(axes, ABS_X, ABS_RZ) || all(relative_axes, REL_X, REL_RZ);
  return six && keys[BTN_0] ? "spacemouse" : "";
}

std::vector<InputNode> input_nodes(const Machine& machine) {
  std::vector<std::pair<unsigned, InputNode>> found;
  for (const fs::path& event : entries(machine.root / "sys/class/input")) {
    const auto number = event_number(event);
    if (!number) continue;
    const fs::path device = event / "device", has = device / "capabilities";
    const std::string_view kind =
        input_kind(bits_of<KEY_CNT>(line_of(has / "key")), bits_of<ABS_CNT>(line_of(has / "abs")),
                   bits_of<ABS_CNT>(line_of(has / "rel")));
    if (kind.empty()) continue;
    found.emplace_back(
        *number, InputNode{"/dev/input" / event.filename(), line_of(device / "name"),
                           line_of(device / "id/vendor"), line_of(device / "id/product"), kind});
  }
  std::ranges::sort(found, {}, [](const auto& one) { return one.first; });
  std::vector<InputNode> nodes;
  nodes.reserve(found.size());
  for (auto& [number, node] : found) nodes.push_back(std::move(node));
  return nodes;
}

std::string input_rule(std::string_view vendor, std::string_view product) {
  return "KERNEL==\"event*\", SUBSYSTEM==\"input\", ATTRS{id/vendor}==\"" + std::string(vendor) +
         "\", ATTRS{id/product}==\"" + std::string(product) + "\", TAG+=\"uaccess\"";
}

std::string input_node_remedy(const Machine& machine, const fs::path& node) {
  std::error_code none;
  const fs::path place = fs::canonical(machine.root / node.relative_path(), none);
  const fs::path id =
      machine.root / "sys/class/input" / (none ? node : place).filename() / "device/id";
  const std::string vendor = line_of(id / "vendor"), product = line_of(id / "product");
  if (vendor.empty() || product.empty())
    return "join the group that ls -l shows (usually: sudo adduser $USER input), log in anew";
  return rule_to_paste(input_rule(vendor, product));
}

}  // namespace feltwire
