#pragma once

#include <filesystem>

#include "sim/studies/bound/zwidth.hpp"

namespace feltwire {

/// Draws zwidth_bB.png for every damping B from the zwidth.csv in `directory`: a panel a method,
/// displayed and commanded stiffness over the servo rate, a colour a delay. Throws
/// std::runtime_error.
void draw_zwidth(const std::filesystem::path& directory, const ZWidthGrid& grid);

}  // namespace feltwire
