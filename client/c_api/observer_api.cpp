// The functions of feltwire.h for an observer.

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/c_api/c_call.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/open_observer.hpp"
#include "client/run/run_client.hpp"

/// The handle of a program.
struct fw_observer : feltwire::Owned<feltwire::OpenObserver> {};

namespace feltwire {
namespace {

constexpr double kShortestPeriod = 1e-3, kLongestPeriod = 0.1;  // [s]

fw_observer_options usual_observer() noexcept {
  fw_observer_options options{};
  options.struct_size = sizeof options;
  options.name = "libfeltwire";
  options.period = ObserverRequest{}.period;
  options.patience = 30.0;
  return options;
}

std::unique_ptr<OpenObserver> open_observer(const fw_observer_options& options) {
  const std::string name = "observer_options";
  if (options.scene == nullptr) throw std::invalid_argument(name + ".scene is null");
  if (!(options.period >= kShortestPeriod && options.period <= kLongestPeriod))
    throw std::invalid_argument(name + ".period must be from 0.001 to 0.1 s");
  if (!(options.patience >= 0.0 && options.patience <= 1e6))
    throw std::invalid_argument(name + ".patience must be from 0 to 1e6 s");
  ServerAccess server = access_of(options, name.c_str());
  ObserverRequest request{.name = text_of(options.name, name + ".name"),
                          .scene = text_of(options.scene, name + ".scene"),
                          .period = options.period,
                          .timeout = kControlTimeout};
  return std::make_unique<OpenObserver>(std::move(server), std::move(request), options.patience);
}

/// Copies the newest list to the structs of a program.
template <class Struct>
std::int32_t copy_list(const LatestList<Struct>& list, Struct* to, std::uint32_t struct_size,
                       std::uint32_t most, std::uint32_t* count) noexcept {
  if (count == nullptr || (to == nullptr && most > 0) || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT,
                "an array or count is null, or struct_size is not the size of its structs");
  std::size_t copied = 0;
  const bool is_there = list.get(to, struct_size, most, copied) > 0;
  *count = static_cast<std::uint32_t>(copied);
  if (struct_size != sizeof(Struct))
    for (std::size_t i = 0; i < copied; ++i)
      std::memcpy(reinterpret_cast<unsigned char*>(to) + i * struct_size, &struct_size,
                  sizeof struct_size);
  return is_there ? FW_OK : FW_NOTHING;
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

void fw_observer_options_default(fw_observer_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_observer(), options, struct_size);
}

std::int32_t fw_observer_open(const fw_observer_options* options, fw_observer** observer) {
  return open_handle(observer, "observer", [&] {
    return open_observer(read_struct(options, usual_observer(), "observer_options"));
  });
}

std::int32_t fw_observer_latest(const fw_observer* observer, fw_scene_state* state,
                                std::uint32_t struct_size) {
  if (!is_open(observer)) return not_open("observer");
  if (state == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "state is null, or struct_size is not its size");
  fw_scene_state newest;
  if (!observer->object->latest(newest)) return FW_NOTHING;
  write_struct(newest, state, struct_size);
  return FW_OK;
}

std::int32_t fw_observer_hands(const fw_observer* observer, fw_seen_hand* hands,
                               std::uint32_t struct_size, std::uint32_t most,
                               std::uint32_t* count) {
  if (!is_open(observer)) return not_open("observer");
  return copy_list(observer->object->hands(), hands, struct_size, most, count);
}

std::int32_t fw_observer_bodies(const fw_observer* observer, fw_seen_body* bodies,
                                std::uint32_t struct_size, std::uint32_t most,
                                std::uint32_t* count) {
  if (!is_open(observer)) return not_open("observer");
  return copy_list(observer->object->bodies(), bodies, struct_size, most, count);
}

std::int32_t fw_observer_hand_name(fw_observer* observer, std::uint32_t number, char* text,
                                   std::uint32_t size) {
  if (!is_open(observer)) return not_open("observer");
  if (text == nullptr || size == 0) return fail(FW_ERROR_ARGUMENT, "text is null, or size is 0");
  return guarded([&] { return give_text(observer->object->name_of(number), text, size); });
}

std::int32_t fw_observer_message(fw_observer* observer, char* text, std::uint32_t size) {
  if (!is_open(observer)) return not_open("observer");
  return give_message(observer->object->messages(), text, size);
}

std::int32_t fw_observer_wait(fw_observer* observer, std::uint64_t number, double timeout) {
  if (!is_open(observer)) return not_open("observer");
  if (!(timeout >= 0.0)) return fail(FW_ERROR_ARGUMENT, "timeout must be 0 or more [s]");
  return guarded([&]() -> std::int32_t {
    switch (observer->object->wait(number, timeout)) {
      case OpenObserver::News::newer:
        return FW_OK;
      case OpenObserver::News::ended:
        return fail(FW_ENDED, observer->object->error().c_str());
      case OpenObserver::News::none:
        break;
    }
    return FW_NOTHING;
  });
}

std::int32_t fw_observer_close(fw_observer* observer) {
  if (observer == nullptr) return FW_OK;
  if (!is_open(observer)) return not_open("observer");
  closes(observer->object.get());
  const std::string error = observer->object->end();
  delete observer;
  return error.empty() ? FW_OK : fail(FW_ENDED, error.c_str());
}
