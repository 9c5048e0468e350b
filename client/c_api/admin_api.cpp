// The functions of feltwire.h for an admin.

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/app/admin_command.hpp"
#include "client/c_api/c_call.hpp"
#include "client/c_api/feltwire.h"
#include "client/run/run_client.hpp"
#include "client/transport/control_client.hpp"

namespace feltwire {

/// A server, and the answer that the program reads.
struct OpenAdmin {
  ServerAccess server;
  std::string answer{};
};

}  // namespace feltwire

/// The handle of a program.
struct fw_admin : feltwire::Owned<feltwire::OpenAdmin> {};

namespace feltwire {
namespace {

fw_admin_options usual_admin() noexcept {
  fw_admin_options options{};
  options.struct_size = sizeof options;
  return options;
}

std::vector<std::string> words_of(const char* const* words, std::uint32_t count) {
  if (words == nullptr || count == 0)
    throw std::invalid_argument("words is null, or count is 0; give a command, as \"sessions\"");
  std::vector<std::string> read;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (words[i] == nullptr) throw std::invalid_argument("words has a null word");
    read.emplace_back(words[i]);
  }
  return read;
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

void fw_admin_options_default(fw_admin_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_admin(), options, struct_size);
}

std::int32_t fw_admin_open(const fw_admin_options* options, fw_admin** admin) {
  return open_handle(admin, "admin", [&] {
    const auto given = read_struct(options, usual_admin(), "admin_options");
    auto opened = std::make_unique<OpenAdmin>(OpenAdmin{access_of(given, "admin_options")});
    list_scenes(opened->server, kControlTimeout);
    return opened;
  });
}

std::int32_t fw_admin_request(fw_admin* admin, const char* const* words, std::uint32_t count,
                              const char** answer) {
  if (answer == nullptr) return fail(FW_ERROR_ARGUMENT, "answer is null");
  *answer = nullptr;
  if (!is_open(admin)) return not_open("admin");
  return guarded([&] {
    admin->object->answer = admin_answer(admin->object->server, words_of(words, count));
    *answer = admin->object->answer.c_str();
    return FW_OK;
  });
}

std::int32_t fw_admin_close(fw_admin* admin) {
  if (admin == nullptr) return FW_OK;
  if (!is_open(admin)) return not_open("admin");
  delete admin;
  return FW_OK;
}
