#include "sim/studies/scene/trade_scene.hpp"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>

#include "server/scene/session.hpp"
#include "sim/measure/cost.hpp"
#include "sim/measure/glide.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kStretch = 500;   // number of timed samples of a case in each round
constexpr std::size_t kWarm = 50;       // number of earlier, untimed samples, which fill the caches
constexpr std::size_t kTicks = 10;      // number of ticks in each round, if the scene has bodies
constexpr std::size_t kSingles = 4000;  // number of samples that are timed one by one

/// Returns the heap memory in use [bytes], by the statistics of malloc. Includes chunks from
/// mmap().
double heap_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// Returns the result of make(), and sets `bytes` to its heap memory. Calls make() in a new thread.
/// A thread that has run before may have a cache of freed chunks, which distorts the count.
template <class Make>
auto weighed(const Make& make, double& bytes) {
  decltype(make()) made;
  const double before = heap_bytes();
  std::thread([&] { made = make(); }).join();
  bytes = heap_bytes() - before;
  return made;
}

control::JoinRequest request(const SceneCase& c) {
  control::JoinRequest request;
  request.client = "hand";
  request.scene = "base";
  request.device = builtin_device("simulated");
  request.device.rotation_sensed = request.device.rotation_actuated = 3;
  request.device.rotational_damping = 1e-3;
  request.device.max_torque = 1.0;
  request.parameters.side = BoundingSide::both;
  request.parameters.local_model = c.local_model;
  request.role = c.role;
  return request;
}

/// The scene of a case, with a session for each client. The hands of the clients move.
class SceneRun {
 public:
  explicit SceneRun(const SceneCase& c) : path_(glide(kGlideBall + c.radius - kGlideDepth)) {
    c.make();  // the first call also makes static and thread-local data
    double unused = 0.0;
    weighed([] { return std::make_unique<int>(); }, unused);
    scene_ = weighed([&] { return std::make_unique<const Scene>(c.make()); }, scene_bytes_);
    if (scene_->mechanism() != nullptr) {
      double bytes = 0.0;
      world_ = weighed([&] { return std::make_unique<World>(*scene_); }, bytes);
      scene_bytes_ += bytes;
    }
    sessions_ = weighed(
        [&] {
          std::vector<std::unique_ptr<Session>> made(c.clients);
          for (auto& session : made)
            session = std::make_unique<Session>(request(c), *scene_, world_.get());
          return made;
        },
        session_bytes_);
    session_bytes_ /= static_cast<double>(c.clients);
    held_.resize(c.clients);
    batch_.count = 1;
    batch_.rotation = scene_->requirements().rotation;
  }

  /// Gives the next sample to a session. The sessions take turns.
  void sample() {
    const std::size_t client = taken_ % sessions_.size();
    const std::uint64_t index = 1 + taken_ / sessions_.size();
    ++taken_;
    Sample& sample = batch_.samples[0];
    sample.index = index;
    sample.client_time = Nanoseconds(static_cast<std::int64_t>(index) * 1'000'000);
    sample.pose.position = path_[(index + client * path_.size() / sessions_.size()) % path_.size()];
    sample.held = held_[client];
    batch_.previous = index - 1;
    const BatchResult taken = sessions_[client]->take(batch_, sample.client_time);
    held_[client] = taken.reply.command;
  }
  bool moves() const { return world_ != nullptr; }
  void tick() {
    for (auto& session : sessions_) session->push(0.0);
    world_->step();
  }

  const Scene& scene() const { return *scene_; }
  double scene_bytes() const { return scene_bytes_; }
  double session_bytes() const { return session_bytes_; }

 private:
  std::vector<Vec3> path_;
  std::unique_ptr<const Scene> scene_;
  std::unique_ptr<World> world_;
  std::vector<std::unique_ptr<Session>> sessions_;
  std::vector<Command> held_;
  SampleBatch batch_;
  std::uint64_t taken_ = 0;
  double scene_bytes_ = 0.0, session_bytes_ = 0.0;
};

using Ticker = std::chrono::steady_clock;

template <class Work>
double single_ns(const Work& work) {
  const auto before = Ticker::now();
  work();
  return std::chrono::duration<double, std::nano>(Ticker::now() - before).count();
}

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0.0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

constexpr double kMedian = 0.5, kOfHundred = 0.99;

template <class Work>
double stretch_ns(const Work& work) {
  for (std::size_t i = 0; i < kWarm; ++i) work();
  return cost_ns(
      kStretch, [&](std::size_t) { work(); }, 1);
}

/// Computes the force of the base scene in two ways: product() with Scene::touch(), and bare() with
/// bare_touch(). Each way has its own bounding method.
class BarePair {
 public:
  explicit BarePair(const Scene& scene)
      : scene_(scene), path_(glide()), contacts_(scene.memory()), bare_(scene.objects().size()) {}

  Command product(std::size_t n) {
    return bounded(scene_.touch(tool(n), contacts_), n, bounds_[0]);
  }
  Command bare(std::size_t n) {
    return bounded(bare_touch(scene_.objects(), tool(n), bare_), n, bounds_[1]);
  }

 private:
  Tool tool(std::size_t n) const { return {path_[n % path_.size()], Vec3::Zero()}; }
  Command bounded(const Command& command, std::size_t n, Bounding& bounding) const {
    const Vec3 moved = path_[n % path_.size()] - path_[(n + path_.size() - 1) % path_.size()];
    return bounding
        .step({.displacement = moved,
               .rotation = Vec3::Zero(),
               .hold_time = kGlidePeriod,
               .command = command})
        .rendered;
  }

  const Scene& scene_;
  std::vector<Vec3> path_;
  TouchMemory contacts_;
  std::vector<ContactMemory> bare_;
  std::array<Bounding, 2> bounds_{Bounding({.damping = 0.5}), Bounding({.damping = 0.5})};
};

}  // namespace

// This function computes the contact with the shapes, and checks for invalid samples. It omits
// friction, damping, velocity, the search tree, guides, tools and moving bodies.
Command bare_touch(std::span<const Object> objects, const Tool& tool,
                   std::span<ContactMemory> memory) noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() || memory.size() != objects.size())
      [[unlikely]]
    return {};
  Command sum;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Object& object = objects[i];
    const Quaternion& to_world = object.pose.orientation;
    const SurfacePoint surface = surface_point(
        object.shape, object.felt_from,
        to_world.conjugate() * (tool.position - object.pose.position), memory[i].feature);
    memory[i].touching = surface.depth > 0.0;
    if (!memory[i].touching) continue;
    sum.elastic += object.material.stiffness * surface.depth * (to_world * surface.normal);
  }
  return sum.finite() ? sum : Command{};
}

BareCost run_bare(std::size_t rounds) {
  const Scene scene = scene_cases().front().make();
  BarePair pair(scene);
  std::vector<double> bare, product, more;
  Vec3 kept = Vec3::Zero();
  std::size_t n = 0;
  const auto lap = [&](bool whole) {
    std::size_t i = n;
    return stretch_ns([&] { kept += (whole ? pair.product(i) : pair.bare(i)).elastic, ++i; });
  };
  for (std::size_t round = 0; round < rounds; ++round) {
    const bool first = round % 2 == 0;  // alternates, because the second lap finds filled caches
    const double a = lap(first), b = lap(!first);
    product.push_back(first ? a : b);
    bare.push_back(first ? b : a);
    more.push_back(product.back() - bare.back());
    n += kWarm + kStretch;
  }
  volatile double used = kept.sum();  // so that the compiler does not remove the work
  static_cast<void>(used);
  return {quantile(bare, kMedian), quantile(product, kMedian), quantile(more, kMedian)};
}

std::vector<SceneCell> run_trade_scene(std::span<const SceneCase> cases, std::size_t rounds) {
  std::vector<std::unique_ptr<SceneRun>> runs;
  for (const SceneCase& c : cases) runs.push_back(std::make_unique<SceneRun>(c));
  struct Times {
    std::vector<double> samples, ratios, ticks;
  };
  std::vector<Times> times(cases.size());
  for (std::size_t round = 0; round < rounds; ++round) {
    double base = 0.0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      SceneRun& run = *runs[i];
      times[i].samples.push_back(stretch_ns([&] { run.sample(); }));
      if (i == 0) base = times[i].samples.back();
      times[i].ratios.push_back(times[i].samples.back() / base);
      for (std::size_t tick = 0; run.moves() && tick < kTicks; ++tick) {
        run.sample();
        times[i].ticks.push_back(single_ns([&] { run.tick(); }));
      }
    }
  }
  std::vector<SceneCell> cells;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    SceneRun& run = *runs[i];
    std::vector<double> singles;
    for (std::size_t n = 0; n < kSingles; ++n) singles.push_back(single_ns([&] { run.sample(); }));
    cells.push_back({.what = cases[i].what,
                     .objects = run.scene().objects().size(),
                     .sample_ns = quantile(times[i].samples, kMedian),
                     .ratio = quantile(times[i].ratios, kMedian),
                     .p99_ns = quantile(std::move(singles), kOfHundred),
                     .tick_ns = quantile(times[i].ticks, kMedian),
                     .scene_bytes = run.scene_bytes(),
                     .session_bytes = run.session_bytes()});
  }
  return cells;
}

}  // namespace feltwire
