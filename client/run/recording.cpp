#include "client/run/recording.hpp"

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
