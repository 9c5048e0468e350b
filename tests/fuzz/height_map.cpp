// Takes arbitrary bytes as a height map. The result must be an image, or an error with the offset
// of the wrong byte. A relief from the image must be finite and within its amplitude everywhere.
//   bytes 0-15  amplitude and size [m], any doubles
//   the rest    the file

#include "core/mesh/height_map.hpp"

#include "core/base/file_error.hpp"
#include "core/base/splitmix.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr double kMost = 1e6;  // [m] limit of a scene's lengths

void require_relief(const HeightMap& map, double amplitude, const Vec3& point, const Vec3& normal) {
  const Relief relief = map.at(point, normal);
  require(relief.cut >= 0.0 && relief.cut <= amplitude * (1 + 1e-5) + 1e-37,
          "a relief is cut no deeper than its amplitude");
  require(std::isfinite(relief.cut), "a relief is somewhere");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  fuzz::Input input(data, size);
  double amplitude = std::abs(input.any_double()), width = std::abs(input.any_double());
  if (!(amplitude > 0.0 && amplitude <= fuzz::kMost)) amplitude = 1e-3;
  if (!(width > 0.0 && width <= fuzz::kMost)) width = 0.1;
  const Bytes rest = input.bytes(input.size());
  GreyImage image;
  try {
    image = parse_pgm(fuzz::text(rest.data(), rest.size()), "map.pgm");
  } catch (const FileError& error) {
    fuzz::require(std::string_view(error.what()).starts_with("map.pgm: byte "),
                  "an error names file and byte");
    return 0;
  }
  fuzz::require(image.width > 0 && image.height > 0 &&
                    image.values.size() == static_cast<std::size_t>(image.width) *
                                               static_cast<std::size_t>(image.height),
                "an image has all its pixels");
  for (const float value : image.values)
    fuzz::require(value >= 0.0f && value <= 1.0f, "a pixel lies between black and white");
  const HeightMap map(image, amplitude, width);
  fuzz::require(map.mean() >= 0.0 && map.mean() <= amplitude * (1 + 1e-5) + 1e-37,
                "the mean lies within the amplitude");
  for (std::uint64_t i = 0; i < 32; ++i) {
    const auto draw = [&](std::uint64_t k) {
      return 2.0 * 0x1p-53 * static_cast<double>(splitmix::draw(2, 8 * i + k) >> 11) - 1.0;
    };
    const double far = i % 4 == 0 ? fuzz::kMost : i % 4 == 1 ? width : 1.0;
    const Vec3 point = far * Vec3(draw(0), draw(1), draw(2));
    const Vec3 normal = Vec3(draw(3), draw(4), draw(5) + 1e-9).normalized();
    fuzz::require_relief(map, amplitude, point, normal);
    fuzz::require_relief(map, amplitude, Vec3::Zero(), normal);
  }
  return 0;
}
