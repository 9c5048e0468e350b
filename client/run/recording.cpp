#include "client/run/recording.hpp"

#include <cmath>

#include "client/run/mcap_recording.hpp"

namespace feltwire {
namespace {

void append_row(std::string& lines, const TickRecord& row) {
  append(lines, row.time);
  for (const Vec3* v : {&row.position, &row.elastic, &row.frictional, &row.held}) {
    for (int i = 0; i < 3; ++i) {
      lines += ',';
      append(lines, (*v)[i]);
    }
  }
  lines += ',';
  append(lines, row.age);
  lines += '\n';
}

}  // namespace

bool RecordingLimits::any() const { return std::isfinite(mebibytes) || std::isfinite(seconds); }

bool is_mcap(const std::filesystem::path& file) { return file.extension() == ".mcap"; }

std::filesystem::path numbered(const RecordingTarget& target, int number) {
  if (!target.limits.any()) return target.file;
  constexpr std::size_t kDigits = 4;
  std::string digits = std::to_string(number);
  if (digits.size() < kDigits) digits.insert(0, kDigits - digits.size(), '0');
  return target.file.parent_path() /
         (target.file.stem().string() + '-' + digits + target.file.extension().string());
}

std::unique_ptr<Recorder> open_recording(const RecordingTarget& target) {
  if (is_mcap(target.file)) return std::make_unique<McapRecording>(target);
  return std::make_unique<CsvRecording>(target.file);
}

CsvRecording::CsvRecording(const std::filesystem::path& file)
    : file_(file, "the recording", "--record", "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n") {}

void CsvRecording::write(Ring<TickRecord>& rows) {
  TickRecord row;
  while (rows.pop(row)) {
    append_row(file_.lines(), row);
    ++rows_;
  }
  file_.put();
}

}  // namespace feltwire
