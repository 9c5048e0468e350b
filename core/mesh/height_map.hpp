#pragma once
// A grey image that is the relief of a surface.

#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// The values of the pixels, row by row from the top, from 0 (black) to 1 (white).
struct GreyImage {
  int width = 0, height = 0;
  std::vector<float> values;
};

/// Reads a portable graymap (PGM: P5 binary of 8 or 16 bits, or P2 text). Errors call it `name`.
/// Throws FileError that names the byte, what is wrong and the remedy.
GreyImage parse_pgm(std::string_view bytes, const std::string& name);

/// The depth of the relief at a place.
struct Relief {
  double cut = 0.0;           // [m] below the surface, >= 0
  Vec3 slope = Vec3::Zero();  // gradient of cut
};

/// The brightest pixels lie on the surface itself; black lies `amplitude` below white. The image
/// repeats without a seam. It is projected along x, y and z, and the three are mixed by the squares
/// of the normal's components. All sides of a body so have the same scale, and its file needs no
/// texture coordinates.
class HeightMap {
 public:
  /// amplitude [m] > 0. size [m] > 0: the width of the image; pixels are square. Throws
  /// std::invalid_argument for an image without pixels.
  HeightMap(const GreyImage& image, double amplitude, double size);

  /// At a point of a surface with this unit normal, both in one frame. Between pixels the relief is
  /// a quadratic B-spline. Its slope is continuous and is the exact gradient of its cut, with the
  /// normal held constant.
  Relief at(const Vec3& point, const Vec3& normal) const noexcept;
  /// [m] The mean of the cut.
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
