#include "client/follower_app/follower_record.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <initializer_list>
#include <mutex>
#include <stdexcept>

namespace feltwire {
namespace {

constexpr std::size_t kRoom = 1 << 14;  // [rows] capacity of the ring: about 16 s at 1 kHz
constexpr std::chrono::milliseconds kBetweenWrites{50};

void append_all(std::string& line, std::initializer_list<double> values) {
  for (const double value : values) {
    line += ',';
    append(line, value);
  }
}
void append_vector(std::string& line, const Vec3& v) { append_all(line, {v.x(), v.y(), v.z()}); }

}  // namespace

FollowerRecord::FollowerRecord(const std::filesystem::path& file)
    : file_(file, "the recording", "--record",
            "t,x,y,z,qw,qx,qy,qz,fx,fy,fz,cx,cy,cz,stiffness,sample,state\n"),
      rows_(kRoom),
      writer_([this](const std::stop_token& end) { write_until(end); }) {}

FollowerRecord::~FollowerRecord() = default;

void FollowerRecord::add(const RobotState& said, const RobotTarget& target) noexcept {
  const double stiffness = said.contact.surface != 0 ? said.contact.stiffness : 0.0;
  const Row row{said.time, said.pose,           said.force,  said.commanded.position,
                stiffness, target.sample_index, target.state};
  if (!rows_.push(row)) dropped_.fetch_add(1);
}

void FollowerRecord::append_row(std::string& lines, const Row& row, double time) {
  append(lines, time);
  append_vector(lines, row.pose.position);
  const Quaternion& q = row.pose.orientation;
  append_all(lines, {q.w(), q.x(), q.y(), q.z()});
  if (row.force)
    append_vector(lines, *row.force);
  else
    lines += ",,,";
  append_vector(lines, row.commanded);
  append_all(lines, {row.stiffness});
  lines += ',' + std::to_string(row.sample) + ',';
  lines += name(row.state);
  lines += '\n';
}

void FollowerRecord::write() {
  Row row;
  while (rows_.pop(row)) {
    if (!first_) first_ = row.time;
    append_row(file_.lines(), row, seconds(row.time - *first_));
  }
  file_.put();
}

void FollowerRecord::write_until(const std::stop_token& end) noexcept {
  std::mutex mutex;
  std::condition_variable_any ended;
  try {
    for (std::unique_lock lock(mutex); !end.stop_requested();) {
      ended.wait_for(lock, end, kBetweenWrites, [] { return false; });
      write();
    }
  } catch (const std::exception& error) {
    error_ = error.what();
  }
}

void FollowerRecord::finish() {
  writer_.request_stop();
  if (writer_.joinable()) writer_.join();
  if (!error_.empty()) throw std::runtime_error(error_);
  write();
  file_.finish();
  if (dropped() > 0)
    throw std::runtime_error("the recording lacks " + std::to_string(dropped()) +
                             " samples, because the disk was slow; give --record a faster one");
}

}  // namespace feltwire
