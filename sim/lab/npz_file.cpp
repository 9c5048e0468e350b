#include "sim/lab/npz_file.hpp"

#include <array>
#include <bit>
#include <limits>
#include <stdexcept>

#include "core/base/little_endian.hpp"
#include "core/recording/compression.hpp"

namespace feltwire {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they lie in memory");

template <class Unsigned>
void put(std::string& out, Unsigned value) {
  std::array<std::uint8_t, sizeof(Unsigned)> bytes;
  put_little_endian(bytes.data(), value);
  out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// Returns the header of an array file, in version 1.0 of the NPY format of NumPy.
std::string npy_head(std::string_view type, std::size_t rows, std::size_t width) {
  constexpr std::size_t kAlignment = 64, kBeforeText = 10;
  std::string text = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" +
                     std::to_string(rows) + ",";
  if (width > 1) text += " " + std::to_string(width);
  text += "), }";
  while ((kBeforeText + text.size() + 1) % kAlignment != 0) text += ' ';
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  put(head, static_cast<std::uint16_t>(text.size()));
  return head + text;
}

template <class Value>
std::string_view bytes_of(std::span<const Value> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

}  // namespace

NpzFile::NpzFile(const std::filesystem::path& file, const std::string& option)
    : file_(file, "the file of arrays", option) {}

void NpzFile::add(const std::string& name, std::span<const double> values, std::size_t width) {
  add(name, "<f8", bytes_of(values), values.size() / width, width);
}

void NpzFile::add(const std::string& name, std::span<const std::int64_t> values) {
  add(name, "<i8", bytes_of(values), values.size(), 1);
}

/// Adds an uncompressed entry to the zip file. The directory of a zip file repeats the headers of
/// its entries, so `directory_` collects them.
void NpzFile::add(const std::string& name, std::string_view type, std::string_view bytes,
                  std::size_t rows, std::size_t width) {
  const std::string head = npy_head(type, rows, width);
  const std::string entry = name + ".npy";
  const std::uint64_t offset = file_.size();
  const std::uint64_t size = head.size() + bytes.size();
  constexpr std::uint64_t kDirectoryRoom = 1 << 16;
  if (offset + size + kDirectoryRoom > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error(
        "the arrays have more than the 4 GiB of a zip; export the files of the recording one by "
        "one, or with --csv");

  std::string common;
  put(common, std::uint16_t{20});  // required zip version: 2.0
  put(common, std::uint16_t{0});
  put(common, std::uint16_t{0});       // compression method: none
  put(common, std::uint16_t{0});       // time: 00:00
  put(common, std::uint16_t{0x0021});  // date: 1980-01-01, so equal arrays give equal files
  put(common, mcap::crc32(bytes, mcap::crc32(head)));
  put(common, static_cast<std::uint32_t>(size));
  put(common, static_cast<std::uint32_t>(size));
  put(common, static_cast<std::uint16_t>(entry.size()));
  put(common, std::uint16_t{0});

  file_.append("PK\x03\x04" + common + entry + head);
  file_.append(bytes);

  directory_ += "PK\x01\x02";
  put(directory_, std::uint16_t{20});
  directory_ += common;
  directory_.append(2 + 2 + 2 + 4, '\0');  // no comment, first disk, no attributes
  put(directory_, static_cast<std::uint32_t>(offset));
  directory_ += entry;
  ++entries_;
}

void NpzFile::finish() {
  std::string end = directory_ + "PK\x05\x06" + std::string(4, '\0');
  put(end, entries_);
  put(end, entries_);
  put(end, static_cast<std::uint32_t>(directory_.size()));
  put(end, static_cast<std::uint32_t>(file_.size()));
  put(end, std::uint16_t{0});
  file_.append(end);
  file_.finish();
}

}  // namespace feltwire
