#pragma once
// Internal to the MCAP reader and writer: zstd and CRC-32.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace feltwire::mcap {

/// CRC-32 as in zip; `before`: that of the preceding bytes.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

class Compressor {
 public:
  /// Throws std::bad_alloc.
  Compressor();
  /// Appends the compressed bytes. Throws std::bad_alloc.
  void compress(std::string_view bytes, std::string& out);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
};

class Decompressor {
 public:
  /// Throws std::bad_alloc.
  Decompressor();
  /// False if `bytes` are not one zstd frame of exactly `size` bytes; then `out` is unspecified. A
  /// frame with another size allocates nothing. Throws std::bad_alloc.
  bool decompress(std::string_view bytes, std::size_t size, std::string& out);

 private:
  struct Free {
    void operator()(ZSTD_DCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_DCtx_s, Free> context_;
};

}  // namespace feltwire::mcap
