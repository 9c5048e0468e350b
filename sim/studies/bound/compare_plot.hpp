#pragma once

#include <filesystem>

#include "sim/studies/bound/compare.hpp"

namespace feltwire {

/// Draws compare.png from the compare.csv in `directory`: a tile a task and method, white good and
/// orange bad, in four panels. `rows` as compare() returns them. Throws std::runtime_error.
void draw_compare(const std::filesystem::path& directory, const std::vector<CompareRow>& rows,
                  const CompareLoop& loop);

}  // namespace feltwire
