#include "client/transport/background_work.hpp"

#include <openssl/ssl.h>
#include <unistd.h>

#include <condition_variable>
#include <cstdlib>
#include <list>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

namespace feltwire {
namespace {

/// The background threads of this process that may still run.
class BackgroundThreads {
 public:
  void start(std::shared_ptr<CancellableWork> work, std::function<void()> task) {
    const std::lock_guard lock(mutex_);
    if (closed_) throw std::runtime_error("the process ends");
    join_ended();
    Entry& entry = entries_.emplace_back();
    entry.work = std::move(work);
    try {
      entry.thread = std::thread(
          [this, &entry, task = std::move(task)]() mutable { run(entry, std::move(task)); });
    } catch (...) {
      entries_.pop_back();
      throw;
    }
  }

  /// Cancels all threads, and waits until they have ended or the patience is over.
  void end() noexcept {
    std::unique_lock lock(mutex_);
    closed_ = true;
    for (const Entry& entry : entries_) entry.work->cancel();
    changed_.wait_for(lock, kPatience, [this] {
      for (const Entry& entry : entries_)
        if (!entry.ended) return false;
      return true;
    });
    join_ended();
  }

 private:
  struct Entry {
    std::thread thread;
    std::shared_ptr<CancellableWork> work;
    bool ended = false;
  };
  static constexpr std::chrono::seconds kPatience{2};

  void run(Entry& entry, std::function<void()> task) noexcept {
    {
      const WorkScope scope(entry.work.get());
      task();
      task = nullptr;  // frees what it owns
    }
    const std::lock_guard lock(mutex_);
    entry.ended = true;
    changed_.notify_all();
  }

  /// Frees the entries of threads that have ended. The mutex is locked.
  void join_ended() noexcept {
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      if (!entry->ended) {
        ++entry;
        continue;
      }
      entry->thread.join();
      entry = entries_.erase(entry);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Entry> entries_;
  bool closed_ = false;  // no other thread is started
};

/// The threads, and the process that has them: a child process has none of its parent's threads.
struct OfProcess {
  pid_t process = 0;
  BackgroundThreads* threads = nullptr;
};
std::mutex mutex_of_process;
OfProcess of_process;

void end_at_exit() {
  if (of_process.process == ::getpid()) of_process.threads->end();
}

BackgroundThreads& threads_of_this_process() {
  const std::lock_guard lock(mutex_of_process);
  if (of_process.process == ::getpid()) return *of_process.threads;
  // OpenSSL must register its exit handler first: handlers run in reverse order.
  ::OPENSSL_init_ssl(0, nullptr);
  auto* threads = new BackgroundThreads;  // never freed: a thread may outlive all exit handlers
  of_process = {::getpid(), threads};
  std::atexit(end_at_exit);
  return *threads;
}

}  // namespace

void run_in_background(std::shared_ptr<CancellableWork> work, std::function<void()> task) {
  threads_of_this_process().start(std::move(work), std::move(task));
}

}  // namespace feltwire
