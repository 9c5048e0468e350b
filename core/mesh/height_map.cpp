#include "core/mesh/height_map.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "core/base/file_error.hpp"
#include "core/base/foreign_content.hpp"

namespace feltwire {
namespace {

constexpr int kMostPixels = 8192;  // largest width and height
constexpr int kMostGrey = 65535;   // largest grey value of 16 bits
constexpr int kMostOfOneByte = 255;

class Pgm {
 public:
  Pgm(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  GreyImage read() {
    if (const auto foreign = foreign_content(bytes_)) fail(*foreign);
    bytes_ = without_byte_order_mark(bytes_);
    // Skip blanks and comments before the first word.
    skip();
    const std::string_view kind = bytes_.substr(at_, 2);
    if (kind != "P5" && kind != "P2")
      fail("is no portable graymap (it begins with neither P5 nor P2); save it as PGM");
    at_ += 2;
    GreyImage image;
    image.width = number("width", 1, kMostPixels);
    image.height = number("height", 1, kMostPixels);
    const int white = number("largest grey", 1, kMostGrey);
    // Each pixel takes at least one byte, so a false header cannot reserve more memory than the
    // file.
    image.values.reserve(std::min(bytes_.size() - at_, static_cast<std::size_t>(image.width) *
                                                           static_cast<std::size_t>(image.height)));
    for (int i = 0; i < image.width * image.height; ++i) {
      const int grey = kind == "P2" ? number("grey", 0, white) : binary(white);
      image.values.push_back(static_cast<float>(grey) / static_cast<float>(white));
    }
    return image;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(name_ + ": byte " + std::to_string(at_) + ": " + what);
  }

  void skip() {
    for (; at_ < bytes_.size(); ++at_) {
      if (bytes_[at_] == '#')
        at_ = std::min(bytes_.find('\n', at_), bytes_.size() - 1);
      else if (std::string_view(" \t\r\n\v\f").find(bytes_[at_]) == std::string_view::npos)
        return;
    }
  }

  int number(const char* what, int least, int most) {
    skip();
    int value = 0;
    const auto [end, error] =
        std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), value);
    if (at_ == bytes_.size()) fail(std::string("it ends before its ") + what + "; copy it anew");
    if (error != std::errc{} || value < least || value > most)
      fail(std::string(what) + " must be a number from " + std::to_string(least) + " to " +
           std::to_string(most) + "; save the image anew, smaller if it is larger");
    at_ = static_cast<std::size_t>(end - bytes_.data());
    return value;
  }

  /// Reads the value of a pixel of a binary file. A single blank separates the header from the
  /// pixels. A two-byte value has its high byte first.
  int binary(int white) {
    if (!begun_) ++at_;
    begun_ = true;
    const std::size_t size = white > kMostOfOneByte ? 2 : 1;
    if (at_ + size > bytes_.size())
      fail("it ends before its pixels do; it was cut short, copy it anew");
    int value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value * (kMostOfOneByte + 1) + static_cast<unsigned char>(bytes_[at_++]);
    if (value > white)
      fail("a pixel of " + std::to_string(value) + " is brighter than its white, " +
           std::to_string(white) + "; save the image anew");
    return value;
  }

  std::string_view bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
  bool begun_ = false;
};

/// Weights of a pixel and its two neighbours (quadratic B-spline), and the derivatives of these
/// weights. `t` in [-1/2, 1/2] is the distance from the pixel's middle, in pixels.
struct Spline {
  explicit Spline(double t)
      : weights{0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)},
        slopes{t - 0.5, -2.0 * t, t + 0.5} {}
  std::array<double, 3> weights, slopes;
};

struct Pixel {
  int index;    // index of the nearest pixel, 0 to count - 1
  double from;  // [pixels] distance from the pixel's middle
};
Pixel pixel_at(double x, int count) {
  double within = x - count * std::floor(x / count);
  if (!(within >= 0.0 && within <= count)) within = 0.0;  // x is not finite, or is too large.
  const double nearest = std::floor(within + 0.5);
  return {static_cast<int>(nearest) % count, within - nearest};
}

}  // namespace

GreyImage parse_pgm(std::string_view bytes, const std::string& name) {
  return Pgm(bytes, name).read();
}

HeightMap::HeightMap(const GreyImage& image, double amplitude, double size)
    : width_(image.width), height_(image.height), pixels_(image.width / size) {
  if (image.values.empty() ||
      image.values.size() != static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_))
    throw std::invalid_argument("image: has no pixels or not all; give another");
  const float brightest = *std::max_element(image.values.begin(), image.values.end());
  cuts_.reserve(image.values.size());
  for (const float value : image.values) {
    cuts_.push_back(static_cast<float>(amplitude) * (brightest - value));
    mean_ += static_cast<double>(cuts_.back());
  }
  mean_ /= static_cast<double>(cuts_.size());
}

HeightMap::Flat HeightMap::look(double along, double across) const noexcept {
  const Pixel column = pixel_at(pixels_ * along, width_), row = pixel_at(pixels_ * across, height_);
  const Spline x(column.from), y(row.from);
  Flat sum;
  for (int j = 0; j < 3; ++j) {
    const auto line = static_cast<std::size_t>((row.index + j + height_ - 1) % height_) *
                      static_cast<std::size_t>(width_);
    double cut = 0.0, slope = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double value = static_cast<double>(
          cuts_[line + static_cast<std::size_t>((column.index + i + width_ - 1) % width_)]);
      cut += x.weights[static_cast<std::size_t>(i)] * value;
      slope += x.slopes[static_cast<std::size_t>(i)] * value;
    }
    sum.cut += y.weights[static_cast<std::size_t>(j)] * cut;
    sum.along += y.weights[static_cast<std::size_t>(j)] * slope * pixels_;
    sum.across += y.slopes[static_cast<std::size_t>(j)] * cut * pixels_;
  }
  return sum;
}

Relief HeightMap::at(const Vec3& point, const Vec3& normal) const noexcept {
  Relief relief;
  for (int axis = 0; axis < 3; ++axis) {
    const double share = normal[axis] * normal[axis];
    if (share == 0.0) continue;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Flat flat = look(point[u], point[v]);
    relief.cut += share * flat.cut;
    relief.slope[u] += share * flat.along;
    relief.slope[v] += share * flat.across;
  }
  return relief;
}

}  // namespace feltwire
