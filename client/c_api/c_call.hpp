#pragma once
// All functions of the C interface share these: results, the text of the last error, and structs of
// older and newer programs.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "client/c_api/end_at_exit.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/message_queue.hpp"
#include "client/servo/event.hpp"
#include "client/transport/control_client.hpp"

namespace feltwire {

/// Keeps the text of the calling thread's last error, in one line. Returns `result`.
std::int32_t fail(std::int32_t result, const char* text) noexcept;
/// That text; empty: there was no error. It is valid until the thread's next error.
const char* last_error() noexcept;

/// The number of times that this process came from a fork() of another one that had the library. A
/// child process has the handles of its parent, but none of its threads.
std::uint32_t forks() noexcept;

/// The object behind a handle of a program, and the process that opened it.
template <class Object>
struct Owned {
  std::unique_ptr<Object> object{};
  std::uint32_t process = forks();
};

/// Whether a handle may be used: it is not null, and this process has opened it.
template <class Object>
bool is_open(const Owned<Object>* handle) noexcept {
  return handle != nullptr && handle->object != nullptr && handle->process == forks();
}

/// The result for a handle that may not be used. `what`: the object of the handle, as "hand".
std::int32_t not_open(const char* what) noexcept;

/// Runs a function, and turns what it throws into a result.
template <class Work>
std::int32_t guarded(Work work) noexcept {
  try {
    return work();
  } catch (const LastingError& error) {
    return fail(FW_ERROR_REFUSED, error.what());
  } catch (const SessionError& error) {
    return fail(FW_ERROR_SERVER, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(FW_ERROR_ARGUMENT, error.what());
  } catch (const std::bad_alloc&) {
    return fail(FW_ERROR_MEMORY, "there is no memory for it");
  } catch (const std::runtime_error& error) {
    return fail(FW_ERROR_DEVICE, error.what());
  } catch (const std::exception& error) {
    return fail(FW_ERROR_INTERNAL, error.what());
  } catch (...) {
    return fail(FW_ERROR_INTERNAL, "an error without a text");
  }
}

/// Opens what is behind a handle, and gives the handle to the program. `name`: of the argument.
template <class Handle, class Open>
std::int32_t open_handle(Handle** handle, const char* name, Open open) noexcept {
  return guarded([&] {
    if (handle == nullptr) throw std::invalid_argument(std::string(name) + " is null");
    *handle = nullptr;
    auto opened = std::make_unique<Handle>();
    opened->object = open();
    auto* object = opened->object.get();
    if constexpr (requires { object->end(); })
      end_at_exit(object, [](void* left_open) noexcept {
        static_cast<decltype(object)>(left_open)->end();
      });
    *handle = opened.release();
    return FW_OK;
  });
}

/// Returns whether a struct can have this size: struct_size and `reserved` at least, and whole
/// fields.
constexpr bool is_size(std::uint32_t size) noexcept {
  constexpr std::uint32_t kLeast = 8, kMost = 4096, kStep = 8;
  return size >= kLeast && size <= kMost && size % kStep == 0;
}

/// Reads `size` [bytes] of a struct of a program that was compiled with an older or a newer header.
/// A field that the program does not know keeps its usual value. Throws std::invalid_argument if it
/// sets a field that this library does not know.
template <class Struct>
Struct read_fields(const void* given, std::uint32_t size, const Struct& usual,
                   const std::string& name) {
  Struct read = usual;
  const auto* bytes = static_cast<const unsigned char*>(given);
  const std::size_t known = std::min<std::size_t>(sizeof read, size);
  std::memcpy(&read, bytes, known);
  if (std::any_of(bytes + known, bytes + size, [](unsigned char byte) { return byte != 0; }))
    throw std::invalid_argument(name +
                                " has a field that this version of the library does not know");
  read.struct_size = sizeof read;
  return read;
}

/// Does the same with the size that the struct says. Throws std::invalid_argument if it has no
/// size.
template <class Struct>
Struct read_struct(const Struct* given, const Struct& usual, const char* name) {
  if (given == nullptr) throw std::invalid_argument(std::string(name) + " is null");
  if (!is_size(given->struct_size))
    throw std::invalid_argument(std::string(name) + ".struct_size is " +
                                std::to_string(given->struct_size) + "; call fw_" + name +
                                "_default() first");
  return read_fields(given, given->struct_size, usual, name);
}

/// Writes as much of a struct as the program knows; the rest of its own becomes zero.
template <class Struct>
void write_struct(Struct value, void* to, std::uint32_t size) noexcept {
  value.struct_size = size;
  std::memset(to, 0, size);
  std::memcpy(to, &value, std::min<std::size_t>(sizeof value, size));
}

/// Writes a text, cut at `size` with its zero byte; an empty one if nothing was found. Returns
/// FW_NOTHING then.
std::int32_t give_text(const std::optional<std::string>& found, char* to,
                       std::uint32_t size) noexcept;
/// Gives the oldest message to a program. Returns an error if `to` has no room.
std::int32_t give_message(MessageQueue& messages, char* to, std::uint32_t size) noexcept;
/// Returns a text of a program as UTF-8; empty where it is null. Throws std::invalid_argument that
/// names it. A path is no text: it has the bytes of the file system.
std::string text_of(const char* given, const std::string& name);
/// Waits until an event is set, at most `timeout` [s]. Returns FW_ENDED if it is, else FW_NOTHING;
/// an error for a timeout that is negative or not a number.
std::int32_t wait_for_end(const Event& over, double timeout) noexcept;

/// Returns the address and the credentials of options with those fields. `name`: of the struct.
/// Throws std::invalid_argument that names a wrong one.
template <class Options>
ServerAccess access_of(const Options& options, const char* name) {
  if (options.server == nullptr) throw std::invalid_argument(std::string(name) + ".server is null");
  const auto text = [](const char* given) { return std::string(given != nullptr ? given : ""); };
  return {parse_endpoint(options.server),
          credentials({.fingerprint = text(options.fingerprint),
                       .fingerprint_file = text(options.fingerprint_file),
                       .ca = text(options.ca_file),
                       .certificate = text(options.certificate_file),
                       .key = text(options.key_file),
                       .token_file = text(options.token_file)})};
}

}  // namespace feltwire
