#include "server/scene/scene_loader.hpp"

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "core/base/cancellation.hpp"
#include "core/scene_file/load_scene.hpp"
#include "server/scene/answer_time.hpp"
#include "server/scene/unreachable_objects.hpp"

namespace feltwire {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kFirstWord{5};  // time until the log says that a load still runs

}  // namespace

namespace {

Scene warned(Scene scene, const std::filesystem::path& file) {
  for (const std::string& warning : scene.warnings())
    spdlog::warn("{}: {}", file.string(), warning);
  for (const std::string& note : scene.notes()) spdlog::info("{}: {}", file.string(), note);
  if (const auto far = warning_of_unreachable_objects(scene))
    spdlog::warn("{}: {}", file.string(), *far);
  if (const auto slow = warning_of_slow_answers(scene))
    spdlog::warn("{}: {}", file.string(), *slow);
  return scene;
}

}  // namespace

Scene load_scene_and_warn(const std::filesystem::path& file) {
  return warned(load_scene(file), file);
}

Scene load_scene_keep_and_warn(const std::filesystem::path& file) {
  return warned(load_scene_and_keep(file), file);
}

/// A load of a scene. The loader and the thread of the load own it together, because the thread may
/// run longer than the loader exists.
struct SceneLoader::Job {
  std::filesystem::path file;
  Load load;
  CancellableWork work;
  Clock::time_point since = Clock::now();
  Clock::duration next_word = kFirstWord;  // time from `since` to the next log line

  std::mutex mutex;
  std::condition_variable ended;
  Done done;  // called with the result; empty: nobody needs the result
  bool running = true;

  /// Returns the scene, or the text of the error. Throws std::bad_alloc if there is no memory for
  /// the text.
  LoadedScene outcome() {
    try {
      const WorkScope doing(&work);
      return load(file);
    } catch (const Cancelled&) {
      return std::string("loading was cancelled");
    } catch (const std::bad_alloc&) {
      return file.string() + ": does not fit into the memory; simplify the scene";
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
  }

  void run() noexcept {
    LoadedScene loaded = std::string("no memory");  // so short that it is not on the heap
    try {
      loaded = outcome();
    } catch (const std::exception&) {
      // There is no memory for the text of the error. `loaded` already says so.
    }
    const std::lock_guard lock(mutex);
    try {
      if (done) done(std::move(loaded));
    } catch (const std::exception& error) {
      spdlog::error("{}: {}", file.string(), error.what());
    }
    done = nullptr;
    running = false;
    ended.notify_all();
  }
};

SceneLoader::SceneLoader(std::size_t scenes, Load load) : load_(std::move(load)), jobs_(scenes) {}

SceneLoader::~SceneLoader() { stop(); }

bool SceneLoader::begin(std::size_t scene, const std::filesystem::path& file, Done done) {
  std::shared_ptr<Job>& job = jobs_[scene];
  if (job != nullptr) {
    const std::lock_guard lock(job->mutex);
    if (job->running) return false;
  }
  auto next = std::make_shared<Job>();
  next->file = file;
  next->load = load_;
  next->done = std::move(done);
  spdlog::info("{}: loading", file.string());
  std::thread([next] { next->run(); }).detach();
  job = std::move(next);
  return true;
}

void SceneLoader::tell() {
  for (const auto& job : jobs_) {
    if (job == nullptr) continue;
    const std::lock_guard lock(job->mutex);
    const auto past = Clock::now() - job->since;
    if (!job->running || past < job->next_word) continue;
    job->next_word *= 2;
    spdlog::info("{}: still loading after {} s: {}", job->file.string(),
                 std::chrono::duration_cast<std::chrono::seconds>(past).count(),
                 job->work.progress());
  }
}

bool SceneLoader::stop(std::chrono::milliseconds patience) {
  const Clock::time_point end = Clock::now() + patience;
  for (const auto& job : jobs_)
    if (job != nullptr) job->work.cancel();
  bool all = true;
  for (const auto& job : jobs_) {
    if (job == nullptr) continue;
    std::unique_lock lock(job->mutex);
    if (job->ended.wait_until(lock, end, [&] { return !job->running; })) continue;
    job->done = nullptr;
    all = false;
  }
  return all;
}

}  // namespace feltwire
