#pragma once

#include <future>
#include <thread>
#include <type_traits>
#include <utility>

namespace feltwire {

/// Calls in a detached thread, and returns the future of its result. The call must own all that it
/// uses: to look up a name can take many seconds, and the end of the program does not wait for
/// that. Throws std::system_error or std::bad_alloc if there is no thread.
template <class Call>
std::future<std::invoke_result_t<Call>> run_detached(Call call) {
  std::packaged_task<std::invoke_result_t<Call>()> task(std::move(call));
  auto result = task.get_future();
  std::thread(std::move(task)).detach();
  return result;
}

}  // namespace feltwire
