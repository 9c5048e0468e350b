#pragma once
// A picture as the relief of a surface.

#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// Row by row from the top, 0 (black) to 1 (white).
struct GreyImage {
  int width = 0, height = 0;
  std::vector<float> values;
};

/// A portable graymap (PGM: P5 binary of 8 or 16 bits, or P2 text). `name` is what errors call it.
/// Throws FileError naming the byte, what is wrong and the remedy.
GreyImage parse_pgm(std::string_view bytes, const std::string& name);

/// A surface lower by `cut` [m] at a place, and how that grows with the place.
struct Relief {
  double cut = 0.0;           // [m], >= 0
  Vec3 slope = Vec3::Zero();  // gradient of cut
};

/// The image's brightest places are the surface itself, black would lie `amplitude` under white.
/// The image repeats without a seam, and is looked at along x, y and z each, mixed as the squares
/// of the normal's parts: the same scale on every side of a body, with no coordinates in its file.
class HeightMap {
 public:
  /// amplitude [m] > 0; size [m] > 0 of the image's width, its pixels are square. Throws
  /// std::invalid_argument for an image without pixels.
  HeightMap(const GreyImage& image, double amplitude, double size);

  /// At a point of a surface with this unit normal, one frame. Between pixels it is a quadratic
  /// B-spline: its slope is continuous and exactly that of its cut (the normal taken for constant).
  Relief at(const Vec3& point, const Vec3& normal) const noexcept;
  /// [m] of the cut, everywhere alike.
  double mean() const { return mean_; }

 private:
  struct Flat {
    double cut = 0.0, along = 0.0, across = 0.0;
  };
  Flat look(double along, double across) const noexcept;

  int width_, height_;
  double pixels_;            // [1/m]
  std::vector<float> cuts_;  // [m]
  double mean_ = 0.0;        // [m]
};

}  // namespace feltwire
