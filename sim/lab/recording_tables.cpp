#include "sim/lab/recording_tables.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>

#include "client/servo/zero_force_reason.hpp"
#include "core/base/file_error.hpp"
#include "core/base/line_file.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/recording/mcap_salvage.hpp"
#include "core/recording/picture_message.hpp"
#include "core/recording/sample_messages.hpp"
#include "server/recording/event_reader.hpp"
#include "server/recording/scene_replay.hpp"
#include "sim/lab/event_tables.hpp"
#include "sim/lab/npz_file.hpp"
#include "sim/replay/replay_report.hpp"

namespace feltwire {
namespace {

constexpr const char* kRemedy = "give a file that --record or --flight-recorder wrote";

std::string reason_text(double value) {
  return value < static_cast<double>(kZeroForceReasons)
             ? std::string(name(static_cast<ZeroForceReason>(value)))
             : std::to_string(static_cast<std::uint32_t>(value));
}

/// Returns the columns of a table of samples. The first columns have the same names as in a file of
/// --record FILE.csv.
std::vector<RecordingTable::Column> sample_columns() {
  return {{"time", "t"},
          {"position", "x,y,z", 3},
          {"elastic", "ex,ey,ez", 3},
          {"frictional", "fx,fy,fz", 3},
          {"held", "rx,ry,rz", 3},
          {"age", "age"},
          {"orientation", "qw,qx,qy,qz", 4},
          {"torque", "tx,ty,tz", 3}};
}

std::vector<RecordingTable::Column> account_columns() {
  return {{"time", "t"},
          {"balance", "balance"},
          {"cut", "cut"},
          {"no_force", "no_force", 1, &reason_text}};
}

std::vector<RecordingTable::Column> body_columns() {
  return {{"time", "t"}, {"position", "x,y,z", 3}, {"orientation", "qw,qx,qy,qz", 4}};
}

std::vector<RecordingTable::Column> hand_columns() {
  std::vector<RecordingTable::Column> columns = body_columns();
  columns.push_back({"held", "rx,ry,rz", 3});
  return columns;
}

/// Returns a file name for a topic: hand_sample for "/hand/sample". The name has no path separator,
/// so the file cannot be outside its folder.
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
      if (column.text != nullptr)
        lines += column.text(value);
      else
        append_exactly(lines, value);
      lines += ',';
    }
  }
  lines += std::to_string(table.log_time[row]) + '\n';
}

/// Reads recordings into tables. The samples and the energy account of a client have a table each.
/// Each hand and each body of the scene pictures has a table. Each hand of a server's recording has
/// the tables of EventTables.
class Reading {
 public:
  void read(const std::filesystem::path& path) {
    std::ifstream in = opened(path);
    mcap::Reader reader(in, file_);
    read(reader);
    if (reader.cut_at()) result_.cuts.emplace_back(path, *reader.cut_at());
  }

  void read_whole_parts(const std::filesystem::path& path) {
    std::ifstream in = opened(path);
    mcap::SalvagedFile file(in, file_);
    mcap::Reader reader(file.whole_parts(), file_);
    read(reader);
    for (const mcap::MissingPart& part : file.missing())
      result_.missing.emplace_back(path, mcap::text(part, first_message_));
    if (!file.missing().empty() && file.missing_messages())
      result_.missing.emplace_back(
          path, "in all " + std::to_string(*file.missing_messages()) + " messages are missing");
  }

  void compute_replies(const std::vector<std::filesystem::path>& files) {
    const auto add = [this](const SceneEvent& event, std::uint64_t time, Bytes reply) {
      events_.add_reply(event, time, reply);
    };
    try {
      const Replay done = replay(files, nullptr, add);
      if (!done.bit_equal())
        throw FileError(files.front().string() +
                        ": its replies cannot be computed again: " + verdict(done));
    } catch (const FileError& error) {
      throw FileError(
          std::string(error.what()) +
          " (--replies needs all files of a server's recording, and its build; leave it "
          "out for other files)");
    }
  }

  ReadRecording result() && { return std::move(result_); }

 private:
  std::ifstream opened(const std::filesystem::path& path) {
    file_ = path.string();
    std::ifstream in(path, std::ios::binary);
    if (!in) throw FileError(file_ + ": cannot be read; check the path");
    return in;
  }

  void read(mcap::Reader& reader) {
    while (const auto message = reader.next()) {
      if (!first_message_) first_message_ = message->log_time;
      take(reader, *message);
    }
  }

  void take(const mcap::Reader& reader, const mcap::Message& message) {
    const mcap::Channel& channel = reader.channels().at(message.channel);
    if (channel.schema == 0) return;
    const std::string& schema = reader.schemas().at(channel.schema).name;
    bool good = true;
    try {
      good = add(channel.topic, schema, message);
    } catch (const std::domain_error&) {
      good = false;
    }
    if (!good)
      throw FileError(file_ + ": topic " + channel.topic + ": message " +
                      std::to_string(message.sequence) + " is no " + schema + "; " + kRemedy);
  }

  /// Adds a message to its table. Returns false if the message does not fit the schema.
  bool add(const std::string& topic, const std::string& schema, const mcap::Message& message) {
    if (schema == "feltwire.Sample")
      return add_sample(table_of(result_.tables, topic, &sample_columns), message);
    if (schema == "feltwire.Account")
      return add_account(table_of(result_.tables, topic, &account_columns), message);
    if (schema == "feltwire.Event")
      return events_.add(event_reader_.read(message, file_), message.log_time);
    if (schema == "foxglove.SceneUpdate" && topic != "/hand/picture") return add_picture(message);
    return true;
  }

  static bool add_sample(RecordingTable& table, const mcap::Message& message) {
    const auto s = read_sample(message.data);
    if (!s) return false;
    const Vec3 &p = s->pose.position, &e = s->elastic, &f = s->frictional, &r = s->held,
               &t = s->torque;
    const Quaternion& q = s->pose.orientation;
    table.add(message.log_time, std::array{s->time, p.x(), p.y(), p.z(), e.x(), e.y(), e.z(),
                                           f.x(),   f.y(), f.z(), r.x(), r.y(), r.z(), s->age,
                                           q.w(),   q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
    return true;
  }

  /// Adds a row of the energy account. The balance is NaN if the session has no account.
  static bool add_account(RecordingTable& table, const mcap::Message& message) {
    const auto a = read_account(message.data);
    if (!a) return false;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    table.add(message.log_time, std::array{a->time, a->balance.value_or(kNone), a->cut,
                                           static_cast<double>(a->no_force)});
    return true;
  }

  bool add_picture(const mcap::Message& message) {
    const auto entities = read_picture(message.data);
    if (!entities) return false;
    if (!first_picture_) first_picture_ = message.log_time;
    // The difference may be negative, because the clock may have been set back.
    const double time =
        1e-9 * static_cast<double>(static_cast<std::int64_t>(message.log_time - *first_picture_));
    for (const PictureEntity& entity : *entities) {
      const Vec3 &p = entity.pose.position, &r = entity.force;
      const Quaternion& q = entity.pose.orientation;
      const std::array row{time,  p.x(), p.y(), p.z(), q.w(), q.x(),
                           q.y(), q.z(), r.x(), r.y(), r.z()};
      const std::string topic = "/scene/" + std::string(entity.id);
      if (entity.is_hand)
        table_of(result_.tables, topic, &hand_columns).add(message.log_time, row);
      else
        table_of(result_.tables, topic, &body_columns)
            .add(message.log_time, std::span(row).first<8>());
    }
    return true;
  }

  ReadRecording result_;
  EventTables events_{result_.tables};
  EventReader event_reader_;
  std::optional<std::uint64_t> first_picture_, first_message_;  // [ns] log times
  std::string file_;
};

}  // namespace

RecordingTable& table_of(RecordingTables& tables, const std::string& topic,
                         std::vector<RecordingTable::Column> (*columns)()) {
  RecordingTable& table = tables[topic];
  if (table.columns.empty()) table.columns = columns();
  return table;
}

void RecordingTable::add(std::uint64_t time, std::span<const double> row) {
  std::size_t at = 0;
  for (const Column& column : columns) at += column.width;
  if (at != row.size()) throw std::domain_error("a table has rows of two kinds");
  at = 0;
  for (Column& column : columns) {
    const auto part = row.subspan(at, column.width);
    column.values.insert(column.values.end(), part.begin(), part.end());
    at += column.width;
  }
  log_time.push_back(static_cast<std::int64_t>(time));
}

ReadRecording read_recording_tables(const std::vector<std::filesystem::path>& files, bool replies,
                                    Damaged damaged) {
  Reading reading;
  for (const auto& file : files)
    damaged == Damaged::skip ? reading.read_whole_parts(file) : reading.read(file);
  if (replies) reading.compute_replies(files);
  return std::move(reading).result();
}

std::vector<std::filesystem::path> write_csv_files(const RecordingTables& tables,
                                                   const std::filesystem::path& folder) {
  constexpr std::size_t kBatch = 1 << 16;  // [bytes] lines are written when they exceed this size
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
