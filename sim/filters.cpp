#include "sim/filters.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <memory>
#include <ostream>
#include <string>

#include "client/csv.hpp"
#include "core/port_energy.hpp"
#include "core/scene/world.hpp"
#include "core/velocity.hpp"

namespace feltwire {
namespace {

/// The shortest text that reads back to the same double.
void append(std::string& line, double value) {
  std::array<char, 32> text;
  value += 0.0;  // people read -0 as a sign
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  if (!line.empty()) line += ',';
  line.append(text.data(), end);
}

void append(std::string& line, const Vec3& v) {
  for (int i = 0; i < 3; ++i) append(line, v[i]);
}

/// Writes a line, and flushes when no more input is waiting: whole speed in a batch, an answer a
/// line on a pipe.
void emit(std::istream& in, std::ostream& out, std::string& line) {
  line += '\n';
  out << line;
  line.clear();
  if (in.rdbuf()->in_avail() <= 0) out.flush();
}

/// A scene as one tool meets it at growing times; what moves is stepped from the first on.
class Touched {
 public:
  explicit Touched(const Scene& scene) : scene_(scene), memory_(scene.memory()) {
    if (scene.mechanism() == nullptr) return;
    world_ = std::make_unique<World>(scene);
    grasp_ = world_->grasp();
  }
  /// `elapsed` [s] since the answer before.
  Command answer(const Tool& tool, double elapsed) {
    if (world_ == nullptr) return scene_.touch(tool, memory_);
    time_ += elapsed;
    while (static_cast<double>(world_->counters().steps + 1) * world_->tick() <=
           time_ + kRounding) {
      world_->push(grasp_, memory_, 1.0);
      world_->step();
    }
    return world_->touch(tool, memory_, grasp_);
  }

 private:
  static constexpr double kRounding = 1e-9;  // [s] of times written in decimals
  const Scene& scene_;
  TouchMemory memory_;
  std::unique_ptr<World> world_;
  Grasp grasp_;
  double time_ = 0.0;  // [s]
};

}  // namespace

std::size_t filter_bound(std::istream& in, std::ostream& out, const BoundingConfig& config) {
  Bounding bounding(config);
  CsvReader reader(in, "stdin", {"dx", "dy", "dz", "ex", "ey", "ez", "fx", "fy", "fz"}, {},
                   CsvReader::NotFinite::accept);
  PortEnergy port(config.damping, 0.0, config.period);
  out << "rx,ry,rz,energy,active\n";
  std::array<double, 9> row{};
  Command held;
  std::size_t refused = 0;
  std::string line;
  while (reader.next(row)) {
    BoundingStep step;
    step.displacement = {row[0], row[1], row[2]};
    step.hold_time = config.period;
    step.command.elastic = {row[3], row[4], row[5]};
    step.command.frictional = {row[6], row[7], row[8]};
    port.step(held, step.displacement, Vec3::Zero(), config.period);
    const Bounded bounded = bounding.step(step);
    held = bounded.rendered;
    refused += bounded.refused;
    append(line, held.force());
    append(line, port.delivered().total());
    line += bounded.active ? ",1" : ",0";
    emit(in, out, line);
  }
  out.flush();
  return refused;
}

std::size_t filter_touch(std::istream& in, std::ostream& out, const Scene& scene) {
  CsvReader reader(in, "stdin", {"t", "x", "y", "z"}, {}, CsvReader::NotFinite::accept);
  Touched touched(scene);
  VelocityEstimate velocity;
  out << "ex,ey,ez,fx,fy,fz\n";
  std::array<double, 4> row{};
  std::size_t refused = 0;
  bool first = true;
  double last_time = 0.0;
  Vec3 last_position = Vec3::Zero();
  std::string line;
  while (reader.next(row)) {
    const double time = row[0];
    const Vec3 position(row[1], row[2], row[3]);
    Command answer;
    if (!std::isfinite(time) || !position.allFinite()) {
      ++refused;
    } else {
      if (!first && !(time > last_time))
        reader.fail("t", "time does not grow; sort the rows by time");
      const double elapsed = first ? 0.0 : time - last_time;
      if (!first) velocity.update(position - last_position, elapsed);
      first = false;
      last_time = time;
      last_position = position;
      answer = touched.answer({position, velocity.value()}, elapsed);
    }
    append(line, answer.elastic);
    append(line, answer.frictional);
    emit(in, out, line);
  }
  out.flush();
  return refused;
}

}  // namespace feltwire
