#pragma once
// MCAP recordings and flight records as tables, and these as CSV files or arrays.

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace feltwire {

/// Rows of one topic.
struct RecordingTable {
  struct Column {
    std::string name;  // of the array: "position"
    std::string csv;   // names in a CSV: "x,y,z"
    std::size_t width = 1;
    std::string (*text)(double) = nullptr;  // a value in a CSV; null: a number
    std::vector<double> values{};           // row by row
  };
  std::vector<Column> columns;
  std::vector<std::int64_t> log_time;  // [ns] since 1970

  /// Adds a row: the values of all columns. Throws std::domain_error if there are more or fewer.
  void add(std::uint64_t time, std::span<const double> row);
};

/// By topic; the time is in the first column of a CSV.
using RecordingTables = std::map<std::string, RecordingTable>;

/// The table of a topic, which gets these columns if it is new.
RecordingTable& table_of(RecordingTables& tables, const std::string& topic,
                         std::vector<RecordingTable::Column> (*columns)());

struct ReadRecording {
  RecordingTables tables;
  /// The files that were cut, and the byte of each.
  std::vector<std::pair<std::filesystem::path, std::uint64_t>> cuts;
  /// With Damaged::skip: one line for each part of a file that is missing, with its file.
  std::vector<std::pair<std::filesystem::path, std::string>> missing;
};

/// The treatment of a file with damaged parts.
enum class Damaged { refuse, skip };

/// Reads the files of one recording, in their order: the samples and accounts of a client, the
/// samples and reports of all hands of a server (event_tables.hpp), and the pictures of a scene.
/// `replies`: computes a server's replies again and adds them, too. Throws FileError that names the
/// file, the place and the remedy. Damaged::skip: reads the whole chunks of damaged files, and
/// lists what is missing.
ReadRecording read_recording_tables(const std::vector<std::filesystem::path>& files,
                                    bool replies = false, Damaged damaged = Damaged::refuse);

/// Writes one file for each topic into the folder, which is created: /hand/sample is
/// hand_sample.csv. Numbers have enough digits to read back the same bits. Returns the files.
std::vector<std::filesystem::path> write_csv_files(const RecordingTables& tables,
                                                   const std::filesystem::path& folder);
/// Writes an array for each column: hand_sample_position.
void write_npz(const RecordingTables& tables, const std::filesystem::path& file);

}  // namespace feltwire
