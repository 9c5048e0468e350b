#pragma once
// The servo ticks of MCAP recordings as tables, and these as CSV files or arrays.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace feltwire {

/// Rows of one topic.
struct RecordingTable {
  struct Column {
    std::string name;  // of the array: "position"
    std::string csv;   // names in a CSV: "x,y,z"
    std::size_t width = 1;
    std::vector<double> values{};  // row by row
  };
  std::vector<Column> columns;
  std::vector<std::int64_t> log_time;  // [ns] since 1970
};

/// By topic; the time is in the first column of a CSV.
using RecordingTables = std::map<std::string, RecordingTable>;

/// Adds the samples and accounts of a file. Returns the byte at which the file was cut, if it was.
/// Throws FileError that names the file, the place and the remedy.
std::optional<std::uint64_t> add_recording(const std::filesystem::path& file,
                                           RecordingTables& tables);

/// Writes one file for each topic into the folder, which is created: /hand/sample is
/// hand_sample.csv. Numbers have enough digits to read back the same bits. Returns the files.
std::vector<std::filesystem::path> write_csv_files(const RecordingTables& tables,
                                                   const std::filesystem::path& folder);
/// One array for each column: hand_sample_position.
void write_npz(const RecordingTables& tables, const std::filesystem::path& file);

}  // namespace feltwire
