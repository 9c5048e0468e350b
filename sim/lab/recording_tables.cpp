#include "sim/lab/recording_tables.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <limits>
#include <span>

#include "client/servo/no_force.hpp"
#include "core/base/file_error.hpp"
#include "core/base/line_file.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/recording/messages.hpp"
#include "sim/lab/npz_file.hpp"

namespace feltwire {
namespace {

constexpr const char* kSample = "feltwire.Sample";
constexpr const char* kAccount = "feltwire.Account";
constexpr const char* kReason = "no_force";  // in a CSV by its name

/// The columns of --record FILE.csv first, under its names.
std::vector<RecordingTable::Column> columns_of(const std::string& schema) {
  if (schema == kSample)
    return {{"time", "t"},
            {"position", "x,y,z", 3},
            {"elastic", "ex,ey,ez", 3},
            {"frictional", "fx,fy,fz", 3},
            {"held", "rx,ry,rz", 3},
            {"age", "age"},
            {"orientation", "qw,qx,qy,qz", 4},
            {"torque", "tx,ty,tz", 3}};
  return {{"time", "t"}, {"balance", "balance"}, {"cut", "cut"}, {kReason, kReason}};
}

void add_row(RecordingTable& table, std::span<const double> row) {
  std::size_t at = 0;
  for (RecordingTable::Column& column : table.columns) {
    const auto part = row.subspan(at, column.width);
    column.values.insert(column.values.end(), part.begin(), part.end());
    at += column.width;
  }
}

bool add_sample(RecordingTable& table, std::string_view bytes) {
  const auto s = read_sample(bytes);
  if (!s) return false;
  const Vec3 &p = s->pose.position, &e = s->elastic, &f = s->frictional, &r = s->held,
             &t = s->torque;
  const Quaternion& q = s->pose.orientation;
  add_row(table,
          std::array{s->time, p.x(), p.y(),  p.z(), e.x(), e.y(), e.z(), f.x(), f.y(), f.z(), r.x(),
                     r.y(),   r.z(), s->age, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
  return true;
}

/// The balance is not a number where there is no account.
bool add_account(RecordingTable& table, std::string_view bytes) {
  const auto a = read_account(bytes);
  if (!a) return false;
  add_row(table, std::array{a->time, a->balance.value_or(std::numeric_limits<double>::quiet_NaN()),
                            a->cut, static_cast<double>(a->no_force)});
  return true;
}

/// "/hand/sample" is hand_sample. No topic leads out of the folder.
std::string file_name(const std::string& topic) {
  std::string name;
  for (const char c : topic) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain || !name.empty()) name += plain ? c : '_';
  }
  return name;
}

void append_exactly(std::string& line, double value) {
  std::array<char, 32> text;
  line.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

void append_row(std::string& lines, const RecordingTable& table, std::size_t row) {
  for (const RecordingTable::Column& column : table.columns) {
    for (std::size_t i = 0; i < column.width; ++i) {
      const double value = column.values[row * column.width + i];
      if (column.name == kReason && value < static_cast<double>(kNoForceReasons))
        lines += name(static_cast<NoForce>(value));
      else
        append_exactly(lines, value);
      lines += ',';
    }
  }
  lines += std::to_string(table.log_time[row]) + '\n';
}

}  // namespace

std::optional<std::uint64_t> add_recording(const std::filesystem::path& file,
                                           RecordingTables& tables) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileError(file.string() + ": cannot be read; check the path");
  mcap::Reader reader(in, file.string());
  while (const auto message = reader.next()) {
    const mcap::Channel& channel = reader.channels().at(message->channel);
    if (channel.schema == 0) continue;
    const std::string& schema = reader.schemas().at(channel.schema).name;
    if (schema != kSample && schema != kAccount) continue;
    RecordingTable& table = tables[channel.topic];
    if (table.columns.empty()) table.columns = columns_of(schema);
    const bool good =
        table.columns.size() == columns_of(schema).size() &&
        (schema == kSample ? add_sample(table, message->data) : add_account(table, message->data));
    if (!good)
      throw FileError(file.string() + ": topic " + channel.topic + ": message " +
                      std::to_string(message->sequence) + " is no " + schema +
                      "; give a file that feltwire-client --record wrote");
    table.log_time.push_back(static_cast<std::int64_t>(message->log_time));
  }
  return reader.cut_at();
}

std::vector<std::filesystem::path> write_csv_files(const RecordingTables& tables,
                                                   const std::filesystem::path& folder) {
  constexpr std::size_t kBatch = 1 << 16;  // [bytes]
  std::filesystem::create_directories(folder);
  std::vector<std::filesystem::path> files;
  for (const auto& [topic, table] : tables) {
    std::string header;
    for (const RecordingTable::Column& column : table.columns) header += column.csv + ',';
    files.push_back(folder / (file_name(topic) + ".csv"));
    LineFile file(files.back(), "the table", "--csv", header + "log_time_ns\n");
    for (std::size_t row = 0; row < table.log_time.size(); ++row) {
      append_row(file.lines(), table, row);
      if (file.lines().size() > kBatch) file.put();
    }
    file.put();
    file.finish();
  }
  return files;
}

void write_npz(const RecordingTables& tables, const std::filesystem::path& file) {
  NpzFile arrays(file, "--npz");
  for (const auto& [topic, table] : tables) {
    const std::string prefix = file_name(topic) + '_';
    for (const RecordingTable::Column& column : table.columns)
      arrays.add(prefix + column.name, column.values, column.width);
    arrays.add(prefix + "log_time", table.log_time);
  }
  arrays.finish();
}

}  // namespace feltwire
