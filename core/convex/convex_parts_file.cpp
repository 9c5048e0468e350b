#include "core/convex/convex_parts_file.hpp"

#include <openssl/evp.h>

#include <bit>
#include <cmath>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>

#include "core/base/little_endian.hpp"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace feltwire {
namespace {

constexpr std::string_view kMagic = "FWPARTS1";
constexpr std::size_t kNumber = 8, kCount = 4, kCorner = 3 * kNumber;  // [bytes] sizes in the file
constexpr std::size_t kDigest = std::tuple_size_v<PartsKey>;
constexpr std::size_t kHead = kMagic.size() + kDigest + kNumber + kCount;
constexpr std::size_t kLeastCorners = 4;

/// Computes the SHA-256 hash of all added bytes, in order.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new()) {
    if (context_ == nullptr) throw std::bad_alloc();
    need(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
  }
  void add(const void* bytes, std::size_t count) {
    need(EVP_DigestUpdate(context_.get(), bytes, count));
  }
  void add(std::string_view text) { add(text.data(), text.size()); }
  void add(std::uint64_t number) {
    std::array<std::uint8_t, kNumber> bytes{};
    put_little_endian(bytes.data(), number);
    add(bytes.data(), bytes.size());
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  PartsKey digest() {
    PartsKey result{};
    need(EVP_DigestFinal_ex(context_.get(), result.data(), nullptr));
    return result;
  }

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  static void need(int done) {
    if (done != 1) throw std::runtime_error("OpenSSL cannot compute a SHA-256");
  }
  std::unique_ptr<EVP_MD_CTX, Free> context_;
};

PartsKey sha256(std::string_view text) {
  Sha256 sum;
  sum.add(text);
  return sum.digest();
}

template <class Unsigned>
void append(std::string& out, Unsigned value) {
  std::array<std::uint8_t, sizeof(Unsigned)> bytes{};
  put_little_endian(bytes.data(), value);
  out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}
void append(std::string& out, double value) { append(out, std::bit_cast<std::uint64_t>(value)); }

std::string_view text_of(const PartsKey& key) {
  return {reinterpret_cast<const char*>(key.data()), key.size()};
}

/// Reads numbers from the front of the bytes. Precondition of each call: enough bytes are left.
class Front {
 public:
  explicit Front(std::string_view bytes) : bytes_(bytes) {}
  std::size_t left() const { return bytes_.size(); }
  std::string_view take(std::size_t count) {
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  template <class Unsigned>
  Unsigned number() {
    return get_little_endian<Unsigned>(
        reinterpret_cast<const std::uint8_t*>(take(sizeof(Unsigned)).data()));
  }
  double real() { return std::bit_cast<double>(number<std::uint64_t>()); }

 private:
  std::string_view bytes_;
};

/// Returns the reason why these points cannot be the corners of a part, or an empty text.
std::string wrong_corners(const std::vector<Vec3>& corners, const TriangleMesh& mesh) {
  constexpr double kSlack = 1e-6;  // rounding errors, as a share of the mesh's size
  const Vec3 most = mesh.half_extents().array() + kSlack * mesh.report().size;
  for (const Vec3& corner : corners)
    if (!(corner.array().abs() <= most.array()).all()) return "has a corner outside of the mesh";
  try {
    const auto hull = convex_hull(corners);
    return hull && hull->volume > 0.0 ? "" : "has a part without a volume";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

PartsKey parts_key(const TriangleMesh& mesh, const DecompositionOptions& options) {
  Sha256 sum;
  sum.add(kMagic);
  sum.add(std::uint64_t{kDecompositionVersion});
  sum.add(std::string_view(qh_version2));
  sum.add(tolerance_of(options, mesh));
  sum.add(std::uint64_t{options.most});
  sum.add(std::uint64_t{mesh.vertices().size()});
  sum.add(std::uint64_t{mesh.triangles().size()});
  static_assert(sizeof(Vec3) == kCorner && sizeof(Triangle) == 3 * kCount);
  sum.add(mesh.vertices().data(), mesh.vertices().size() * sizeof(Vec3));
  sum.add(mesh.triangles().data(), mesh.triangles().size() * sizeof(Triangle));
  return sum.digest();
}

std::string hex(const PartsKey& key) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : key) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string convex_parts_bytes(const ConvexParts& parts, const PartsKey& key) {
  std::string out(kMagic);
  out += text_of(key);
  append(out, parts.outside);
  append(out, static_cast<std::uint32_t>(parts.parts.size()));
  for (const std::vector<Vec3>& part : parts.parts) {
    append(out, static_cast<std::uint32_t>(part.size()));
    for (const Vec3& corner : part)
      for (const double number : corner) append(out, number);
  }
  out += text_of(sha256(out));
  return out;
}

std::variant<ConvexParts, std::string> read_convex_parts(std::string_view bytes,
                                                         const PartsKey& key,
                                                         const TriangleMesh& mesh,
                                                         const DecompositionOptions& options) {
  using std::string;
  if (!bytes.starts_with(kMagic)) return string("is no file of convex parts");
  if (bytes.size() < kHead + kDigest || bytes.size() > kMostConvexPartsFile)
    return string("has a length that no file of convex parts has");
  const std::string_view all = bytes.substr(0, bytes.size() - kDigest);
  if (text_of(sha256(all)) != bytes.substr(all.size()))
    return string("is damaged: its sum is not that of its bytes");
  Front front(all.substr(kMagic.size()));
  if (front.take(kDigest) != text_of(key))
    return string("is of another mesh, of other options or of another version");
  ConvexParts result{{}, tolerance_of(options, mesh), front.real()};
  if (!(result.outside >= 0.0 && result.outside <= 2.0 * mesh.report().size))
    return string("has parts that reach out of the mesh by more than its size");
  const auto count = front.number<std::uint32_t>();
  if (count < 1 || count > options.most)
    return "has " + std::to_string(count) + " parts where 1 to " + std::to_string(options.most) +
           " are asked for";
  for (std::uint32_t i = 0; i < count; ++i) {
    if (front.left() < kCount) return string("ends before its last part");
    const auto corners = front.number<std::uint32_t>();
    if (corners < kLeastCorners || corners > front.left() / kCorner)
      return string("has a part of more corners than it has bytes for, or of less than four");
    std::vector<Vec3>& part = result.parts.emplace_back(corners);
    for (Vec3& corner : part)
      for (double& number : corner) number = front.real();
    if (string wrong = wrong_corners(part, mesh); !wrong.empty()) return wrong;
  }
  if (front.left() > 0) return string("goes on behind its last part");
  return result;
}

}  // namespace feltwire
