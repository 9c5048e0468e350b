#include "core/recording/compression.hpp"

#include <zlib.h>
#include <zstd.h>

#include <new>

namespace feltwire::mcap {
namespace {

// Level of the zstd compression. Level 3 makes servo ticks 5 % smaller, but takes 1.7 times as long
// (bench record/mcap/16).
constexpr int kLevel = 1;

}  // namespace

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

Compressor::Compressor() : context_(ZSTD_createCCtx()) {
  if (context_ == nullptr) throw std::bad_alloc();
}

void Compressor::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }

void Compressor::compress(std::string_view bytes, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compressCCtx(
      context_.get(), out.data() + before, out.size() - before, bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size)) throw std::bad_alloc();  // Only a lack of memory is possible here.
  out.resize(before + size);
}

Decompressor::Decompressor() : context_(ZSTD_createDCtx()) {
  if (context_ == nullptr) throw std::bad_alloc();
}

void Decompressor::Free::operator()(ZSTD_DCtx_s* context) const { ZSTD_freeDCtx(context); }

bool Decompressor::decompress(std::string_view bytes, std::size_t size, std::string& out) {
  const unsigned long long said = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (said == ZSTD_CONTENTSIZE_ERROR) return false;
  if (said != ZSTD_CONTENTSIZE_UNKNOWN && said != size) return false;
  out.resize(size);
  const std::size_t written =
      ZSTD_decompressDCtx(context_.get(), out.data(), out.size(), bytes.data(), bytes.size());
  return !ZSTD_isError(written) && written == size;
}

}  // namespace feltwire::mcap
