#include "sim/studies/network/local_model_study.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene_file/load_scene.hpp"
#include "scenes/room_text.hpp"
#include "sim/measure/fidelity.hpp"

namespace feltwire {
namespace {

constexpr double kBall = 0.09;    // [m] radius of the ball
constexpr int kBallLevel = 6;     // subdivision level of the ball's mesh: 81920 triangles
constexpr double kGrid = 2e-3;    // [m] resolution of the distance grid
constexpr double kRolled = 5e-3;  // [m] radius of the rolling tool
constexpr Grain kFine{2e-5, 2e-3}, kCoarse{1e-4, 1e-2};
constexpr double kStiffness = 1000.0;  // [N/m] stiffness of the surfaces in this file
constexpr double kPress = 3.0;         // [N] force with which the hand presses
constexpr double kDuration = 4.0;      // [s] duration of a run
constexpr double kSettled = 0.5;       // [s] a session may lack replies until then

struct Task {
  std::string name;
  Scene scene;
  HandTask hand;
};

Object object(const char* name, const Shape& shape, const Vec3& position, const Material& material,
              Side side = Side::outside) {
  Object o;
  o.name = name;
  o.shape = shape;
  o.felt_from = side;
  o.pose.position = position;
  o.material = material;
  return o;
}

HandTask hand(HandPath path, double depth = kPress / Hand{}.stiffness) {
  HandTask task;
  task.path = path;
  task.depth = depth;
  task.lead_in = 1.0;
  return task;
}

/// Returns the tasks in the order of the result table.
std::vector<Task> all_tasks() {
  const Material smooth{.stiffness = kStiffness};
  const Material rough{.stiffness = kStiffness, .static_friction = 0.5, .dynamic_friction = 0.4};
  const Object wall = object("wall", Plane{}, Vec3::Zero(), smooth);
  std::vector<Task> tasks;

  // The hand and the wall are springs in series, so the depth includes the wall's compression.
  tasks.push_back({"press", Scene("press", {wall}),
                   hand(HandPath::press, kPress / Hand{}.stiffness + kPress / kStiffness)});
  HandTask taps = hand(HandPath::taps);
  taps.frequency = 2.0;
  tasks.push_back({"taps", Scene("taps", {wall}), taps});

  HandTask orbit = hand(HandPath::orbit);
  go_round(orbit, kBall);
  orbit.clearance *= 2.0;  // the clearance counts from the path, which is inside the ball
  tasks.push_back(
      {"ball", Scene("ball", {object("ball", Sphere{kBall}, Vec3::Zero(), smooth)}), orbit});

  // The next tasks use this ball as a triangle mesh, and later as a distance grid.
  const Object facets = object(
      "ball", Mesh{std::make_shared<MeshSurface>(TriangleMesh(icosphere(kBall, kBallLevel)))},
      Vec3::Zero(), smooth);
  tasks.push_back({"mesh", Scene("mesh", {facets}), orbit});
  // Further tasks: a tool with a radius rolls on the mesh, and the mesh has a fine or a coarse
  // texture. During a round trip, the hand moves farther than the wavelength of kFine, but less
  // than the wavelength of kCoarse.
  const auto textured = [&](const char* name, const MeshOptions& options) {
    const Mesh mesh{
        std::make_shared<MeshSurface>(TriangleMesh(icosphere(kBall, kBallLevel)), options)};
    return Scene(name, {object("ball", mesh, Vec3::Zero(), smooth)});
  };
  HandTask roll = hand(HandPath::orbit);
  go_round(roll, kBall + kRolled);
  roll.clearance *= 2.0;
  tasks.push_back({"ball_mesh", textured("ball_mesh", {.radius = kRolled}), roll});
  tasks.push_back({"grain", textured("grain", {.grain = kFine}), orbit});
  tasks.push_back({"relief", textured("relief", {.grain = kCoarse}), orbit});
  const Object sampled = object("ball",
                                Grid{std::make_shared<DistanceGrid<float>>(
                                    solid_of(Sphere{kBall}), GridOptions{.resolution = kGrid})},
                                Vec3::Zero(), smooth);
  tasks.push_back({"grid", Scene("grid", {sampled}), orbit});

  HandTask slide = hand(HandPath::slide);
  slide.frequency = 1.0;
  tasks.push_back(
      {"friction", Scene("friction", {object("wall", Plane{}, Vec3::Zero(), rough)}), slide});

  // The block's edge is under the middle of the path, so the hand leaves the block and returns.
  slide.frequency = 0.5;
  const Vec3 half(0.05, 0.05, 0.05);  // [m] half extents of the block
  tasks.push_back(
      {"edge", Scene("edge", {object("block", Box{half}, Vec3(-half.x(), 0, -half.z()), smooth)}),
       slide});

  // The block is now a mesh, and a ball rolls over its edge.
  const Object rounded =
      object("block",
             Mesh{std::make_shared<MeshSurface>(TriangleMesh(tessellate(Box{half}, 4)),
                                                MeshOptions{.radius = kRolled})},
             Vec3(-half.x(), 0, -half.z()), smooth);
  HandTask rolled_over = slide;
  rolled_over.center.z() += kRolled;
  tasks.push_back({"ball_edge", Scene("ball_edge", {rounded}), rolled_over});

  // The hand moves in the corner of a floor and two walls, along these surfaces.
  HandTask corner = hand(HandPath::orbit, kPress / Hand{}.stiffness);
  corner.center = Vec3(0.01, 0.01, 0.0);
  corner.radius = 0.02;
  tasks.push_back({"corner",
                   Scene("corner", {object("room", Box{Vec3(0.2, 0.2, 0.2)}, Vec3(0.2, 0.2, 0.2),
                                           smooth, Side::inside)}),
                   corner});

  // The hand moves over the objects on the table.
  HandTask things = hand(HandPath::figure_eight);
  things.radius = 0.06;
  things.frequency = 0.25;
  const Scene room = parse_scene(embedded::room, "room.json");
  things.center = room.start().position;
  tasks.push_back({"room", room, things});
  return tasks;
}

NetworkRunOptions options_of(const Task& task, const LocalModelCell& cell) {
  NetworkRunOptions options;
  options.hand.spec = builtin_device("simulated");
  options.hand.task = task.hand;
  options.parameters.servo_period = 1.0 / cell.rate;
  options.parameters.local_model = cell.modelled;
  options.link.up.delay = options.link.down.delay = 0.5 * cell.round_trip;
  options.duration = kDuration;
  return options;
}

/// Returns the slope [N/m] of the normal force over the true depth while the depth grows, by least
/// squares.
double pressing_slope(const std::vector<NetworkSample>& samples) {
  double deepest = 0.0, n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const NetworkSample& s : samples) {
    const double depth = -s.position.z();
    if (depth <= deepest) continue;
    deepest = depth;
    const double force = s.held.force().z();
    n += 1, x += depth, y += force, xx += depth * depth, xy += depth * force;
  }
  const double spread = n * xx - x * x;
  return spread > 0.0 ? (n * xy - x * y) / spread : 0.0;
}

/// Returns the delay [s] of the contact force: from the first contact at the true position to the
/// first force on the hand.
double onset(const std::vector<NetworkSample>& samples) {
  const auto touched = std::ranges::find_if(
      samples, [](const NetworkSample& s) { return s.ideal.force().norm() > 0.0; });
  const auto felt = std::ranges::find_if(
      samples, [](const NetworkSample& s) { return s.held.force().norm() > 0.0; });
  if (touched == samples.end() || felt == samples.end()) return 0.0;
  return felt->time - touched->time;
}

/// Returns the samples without those of the first kSettled seconds, in which a session may lack
/// replies.
std::vector<NetworkSample> settled(const std::vector<NetworkSample>& samples, double rate) {
  const auto first = static_cast<std::ptrdiff_t>(std::llround(kSettled * rate));
  return {samples.begin() + first, samples.end()};
}

void measure(const Task& task, const NetworkRunOptions& options, LocalModelCell& cell) {
  const NetworkRunResult run = run_network(task.scene, options);
  const double ticks = static_cast<double>(run.samples.size());
  const double time = ticks / cell.rate;
  const auto samples = settled(run.samples, cell.rate);
  const Fidelity felt = fidelity(samples);
  cell.felt = felt.felt;
  cell.error = felt.error;
  cell.direction_error = felt.direction.mean;
  if (task.name == "press") cell.displayed = pressing_slope(run.samples);
  cell.onset = onset(run.samples);
  cell.oscillation = oscillation(run.samples, cell.rate);
  cell.from_model = static_cast<double>(run.servo.local_model.from_model) / ticks;
  cell.patches = run.servo.local_model.received > 0
                     ? static_cast<double>(run.servo.local_model.patches) /
                           static_cast<double>(run.servo.local_model.received)
                     : 0.0;
  cell.datagrams = static_cast<double>(run.up.datagrams) / time;
  cell.kbit_up = run.up.kbit_per_second(time);
  cell.kbit_down = run.down.kbit_per_second(time);
  cell.violations = run.measured_port.violations();
}

}  // namespace

std::vector<LocalModelCell> run_local_model(const LocalModelGrid& grid) {
  constexpr double kUsualRate = 1e3;  // [Hz] usual servo rate
  const std::vector<Task> tasks = all_tasks();
  struct Job {
    const Task* task;
    bool thin;
  };
  std::vector<Job> jobs;
  std::vector<LocalModelCell> cells;
  const auto add = [&](const Task& task, double round_trip, double rate, bool thin) {
    for (const bool modelled : {false, true}) {
      LocalModelCell cell;
      cell.task = task.name;
      cell.round_trip = round_trip;
      cell.rate = rate;
      cell.modelled = modelled;
      cells.push_back(cell);
      jobs.push_back({&task, thin});
    }
  };
  for (const Task& task : tasks)
    for (const double round_trip : grid.round_trips) add(task, round_trip, kUsualRate, false);
  for (const Task& task : tasks)
    if (task.name == "ball")
      for (const double rate : grid.rates) {
        if (rate != kUsualRate) add(task, 0.0, rate, false);  // the loop above has added this cell
        add(task, kUsualRoundTrip, rate, true);
      }

  parallel_for(cells.size(), [&](std::size_t i) {
    NetworkRunOptions options = options_of(*jobs[i].task, cells[i]);
    if (jobs[i].thin) {
      options.parameters.packet_interval =
          static_cast<int>(std::llround(cells[i].rate / kThinRate));
      options.parameters.redundancy = 0;
    }
    measure(*jobs[i].task, options, cells[i]);
  });
  return cells;
}

}  // namespace feltwire
