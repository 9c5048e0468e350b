#include "sim/lab/filters.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <memory>
#include <ostream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/hands/amplifier.hpp"
#include "core/base/csv.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/bounding/velocity.hpp"
#include "core/dynamics/world.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

/// Appends the shortest text that a reader converts back to the same double.
void append(std::string& line, double value) {
  std::array<char, 32> text;
  value += 0.0;  // turns -0 into 0, which is easier to read
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  if (!line.empty()) line += ',';
  line.append(text.data(), end);
}

void append(std::string& line, const Vec3& v) {
  for (int i = 0; i < 3; ++i) append(line, v[i]);
}

/// Writes a line. Flushes `out` only if no input is waiting. So a large input is processed fast,
/// and a single line gets its result at once.
void emit(std::istream& in, std::ostream& out, std::string& line) {
  line += '\n';
  out << line;
  line.clear();
  if (in.rdbuf()->in_avail() <= 0) out.flush();
}

/// Computes the force of a scene on one tool, for successive poses of the device. The bodies of the
/// scene start to move at the first pose.
class Touched {
 public:
  Touched(const Scene& scene, const ToolView& view) : view_(view), memory_(view.memory()) {
    if (scene.mechanism() == nullptr) return;
    world_ = std::make_unique<World>(scene);
    body_contacts_ = world_->contact_state(view);
  }
  /// Returns the force and torque on the hand. `elapsed` [s]: time since the last call.
  Command answer(const Pose& device, const Vec3& velocity, double elapsed) {
    if (view_.tool().body != nullptr) {
      if (world_ == nullptr) return view_.touch(device, velocity, elapsed, body_memory_);
      advance(elapsed, body_memory_);
      return world_->touch(device, velocity, elapsed, body_memory_, body_contacts_);
    }
    const Tool tool{device.position, velocity};
    if (world_ == nullptr) return view_.touch(tool, memory_);
    advance(elapsed, memory_);
    return world_->touch(tool, memory_, body_contacts_);
  }

 private:
  static constexpr double kRounding = 1e-9;  // [s] largest rounding error of `time_`

  template <class Memory>
  void advance(double elapsed, Memory& memory) {
    time_ += elapsed;
    while (static_cast<double>(world_->counters().steps + 1) * world_->tick() <=
           time_ + kRounding) {
      world_->push(body_contacts_, memory, 1.0);
      world_->step();
    }
  }

  const ToolView& view_;
  TouchMemory memory_;
  BodyMemory body_memory_;
  std::unique_ptr<World> world_;
  BodyContactState body_contacts_;
  double time_ = 0.0;  // [s]
};

const ToolView& view_of(const Scene& scene, const std::string& tool) {
  if (const ToolView* view = scene.view(tool)) return *view;
  const std::string names = scene.tool_names();
  throw std::invalid_argument(
      "--tool: the scene has no tool '" + tool + "'; " +
      (names.empty() ? "it names none, leave --tool out" : "the existing ones are: " + names));
}

}  // namespace

namespace {

// The largest number of required columns, and the number of optional columns. The optional columns
// are the hold time, a flag for a force at the current position of the device, and three normals.
constexpr std::size_t kMostColumns = 15, kOptional = 11;
const std::vector<std::string> kRowColumns = {"hold", "local", "n1x", "n1y", "n1z", "n2x",
                                              "n2y",  "n2z",   "n3x", "n3y", "n3z"};

/// Returns the normals in `row`, which has the values of kRowColumns. Ignores normals of 0,0,0.
ContactNormals normals_of(const CsvReader& reader, std::span<const double> row) {
  ContactNormals normals;
  for (std::size_t n = 0; n < ContactNormals::kMost; ++n) {
    const std::size_t at = 2 + 3 * n;
    const Vec3 normal(row[at], row[at + 1], row[at + 2]);
    if (!normal.allFinite())
      reader.fail(kRowColumns[at], "the normal is not finite; give 0,0,0 for none");
    if (normal.norm() > 0.0) normals.add(normal.normalized());
  }
  return normals;
}

void require_whole_normals(const CsvReader& reader) {
  for (std::size_t at = 2; at < kOptional; at += 3) {
    int count = 0;
    for (std::size_t i = at; i < at + 3; ++i) count += reader.has(kRowColumns[i]) ? 1 : 0;
    if (count == 1 || count == 2)
      throw CsvError("stdin:1: a normal has three columns; give all of " + kRowColumns[at] + "," +
                     kRowColumns[at + 1] + "," + kRowColumns[at + 2]);
  }
}

/// The energy that a true motor gives behind its amplifier.
class MotorEnergy {
 public:
  explicit MotorEnergy(const Plant::Amplifier& amplifier)
      : force_(amplifier, 1), torque_(without_resolution(amplifier), 1) {}

  /// The device moved evenly over `time` [s], and then `written` was written. Returns the energy so
  /// far [J]. Ignores a movement that is not finite.
  double moved(const BoundingStep& step, double time, const Command& written) {
    const Vec3 force = force_.mean(now_, time), torque = torque_.mean(now_, time);
    now_ += time;
    const double given = force.dot(step.displacement) + torque.dot(step.rotation);
    if (std::isfinite(given)) given_ += given;
    force_.write(now_, written.force());
    torque_.write(now_, written.torque);
    return given_;
  }

 private:
  static Plant::Amplifier without_resolution(Plant::Amplifier amplifier) {
    amplifier.resolution = 0.0;  // the resolution applies to forces only
    return amplifier;
  }
  Amplifier force_, torque_;
  double now_ = 0.0, given_ = 0.0;  // [s], [J]
};

}  // namespace

std::size_t filter_bound(std::istream& in, std::ostream& out, const BoundingConfig& config,
                         const std::optional<AccountConfig>& account_config,
                         const std::optional<Plant::Amplifier>& amplifier) {
  Bounding bounding(config);
  std::optional<PortAccount> account;
  if (account_config) account.emplace(*account_config);
  std::optional<MotorEnergy> motor;
  if (amplifier) motor.emplace(*amplifier);
  std::vector<std::string> columns = {"dx", "dy", "dz", "ex", "ey", "ez", "fx", "fy", "fz"};
  if (config.rotation) columns.insert(columns.end(), {"ax", "ay", "az", "tx", "ty", "tz"});
  CsvReader reader(in, "stdin", columns, kRowColumns, CsvReader::NotFinite::accept);
  require_whole_normals(reader);
  PortEnergy port(config.damping, config.rotational_damping, config.period);
  out << (config.rotation ? "rx,ry,rz,rtx,rty,rtz,energy,active" : "rx,ry,rz,energy,active")
      << (account ? ",balance" : "") << (motor ? ",motor\n" : "\n");
  std::array<double, kMostColumns> row{};
  std::array<double, kMostColumns + kOptional> numbers{};
  const std::span values = std::span(numbers).first(columns.size() + kOptional);
  const std::span options = values.last(kOptional);
  options[0] = config.period;
  Command held;
  std::size_t refused = 0;
  std::string line;
  while (reader.next(values)) {
    std::copy_n(numbers.begin(), columns.size(), row.begin());
    if (!(std::isfinite(options[0]) && options[0] > 0.0))
      reader.fail("hold", "a hold is a time above 0 in seconds");
    if (options[1] != 0.0 && options[1] != 1.0)
      reader.fail("local", "use 1 for a force that was computed here, 0 for one that is late");
    const ContactNormals normals = normals_of(reader, options);
    BoundingStep step;
    step.displacement = {row[0], row[1], row[2]};
    step.hold_time = options[0];
    step.command.elastic = {row[3], row[4], row[5]};
    step.command.frictional = {row[6], row[7], row[8]};
    step.rotation = {row[9], row[10], row[11]};
    step.command.torque = {row[12], row[13], row[14]};
    step.local = options[1] == 1.0;
    step.normals = &normals;
    port.step(held, step.displacement, step.rotation, step.hold_time);
    const Bounded bounded = bounding.step(step);
    held = bounded.rendered;
    bool active = bounded.active;
    if (account) {
      step.command = bounded.rendered;
      held = account->step(step);
      active = active || held != bounded.rendered;
      bounding.set_held(held);
    }
    refused += bounded.refused;
    append(line, held.force());
    if (config.rotation) append(line, held.torque);
    append(line, port.delivered().total());
    line += active ? ",1" : ",0";
    if (account) append(line, account->balance());
    if (motor) append(line, motor->moved(step, step.hold_time, held));
    emit(in, out, line);
  }
  out.flush();
  return refused;
}

std::size_t filter_touch(std::istream& in, std::ostream& out, const Scene& scene,
                         const std::string& tool) {
  const ToolView& view = view_of(scene, tool);
  const bool body = view.tool().body != nullptr;
  std::vector<std::string> columns = {"t", "x", "y", "z"};
  if (body) columns.insert(columns.end(), {"qw", "qx", "qy", "qz"});
  CsvReader reader(in, "stdin", columns, {}, CsvReader::NotFinite::accept);
  Touched touched(scene, view);
  VelocityEstimate velocity;
  out << "ex,ey,ez,fx,fy,fz" << (body ? ",tx,ty,tz\n" : "\n");
  std::array<double, 8> row{0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  std::size_t refused = 0;
  bool first = true;
  double last_time = 0.0;
  Vec3 last_position = Vec3::Zero();
  std::string line;
  while (reader.next(std::span(row).first(columns.size()))) {
    const double time = row[0];
    const Vec3 position(row[1], row[2], row[3]);
    Quaternion turn(row[4], row[5], row[6], row[7]);
    Command answer;
    if (!std::isfinite(time) || !position.allFinite() || !turn.coeffs().allFinite()) {
      ++refused;
    } else {
      if (!first && !(time > last_time))
        reader.fail("t", "time does not grow; sort the rows by time");
      if (!(turn.coeffs().cwiseAbs().maxCoeff() > 0.0))
        reader.fail("qw", "qw,qx,qy,qz are no rotation, all are zero; give 1,0,0,0 for none");
      turn.coeffs() /= turn.coeffs().cwiseAbs().maxCoeff();
      turn.normalize();
      const double elapsed = first ? 0.0 : time - last_time;
      if (!first) velocity.update(position - last_position, elapsed);
      first = false;
      last_time = time;
      last_position = position;
      answer = touched.answer({position, turn}, velocity.value(), elapsed);
    }
    append(line, answer.elastic);
    append(line, answer.frictional);
    if (body) append(line, answer.torque);
    emit(in, out, line);
  }
  out.flush();
  return refused;
}

}  // namespace feltwire
