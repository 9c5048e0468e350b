#include "client/recording.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <initializer_list>
#include <stdexcept>

namespace feltwire {
namespace {

void append(std::string& line, double value) {
  constexpr int kDigits = 9;  // a nanometre in a metre, a nanonewton in a newton
  char text[32];
  const auto end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::general, kDigits).ptr;
  line.append(text, end);
}

void append(std::string& lines, const TickRecord& row) {
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

RecordingFile::RecordingFile(const std::filesystem::path& file) : file_(file) {
  constexpr int kForAll = 0644;
  descriptor_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kForAll);
  if (descriptor_ < 0)
    throw std::runtime_error("cannot write the recording " + file.string() + ": " +
                             std::strerror(errno) + "; check the path in --record");
  lines_ = "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n";
  put_out();
}

RecordingFile::~RecordingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void RecordingFile::write(Ring<TickRecord>& rows) {
  TickRecord row;
  while (rows.pop(row)) {
    append(lines_, row);
    ++rows_;
  }
  put_out();
}

void RecordingFile::put_out() {
  std::size_t done = 0;
  while (done < lines_.size()) {
    const ssize_t written = ::write(descriptor_, lines_.data() + done, lines_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      lines_.clear();
      throw std::runtime_error("the recording " + file_.string() +
                               " ends here: " + std::strerror(errno));
    }
    done += static_cast<std::size_t>(written);
  }
  lines_.clear();
}

}  // namespace feltwire
