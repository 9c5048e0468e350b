#pragma once

#include <future>

#include "server/app/server.hpp"

namespace feltwire::test {

/// Reloads all scenes and waits for the end; returns the errors.
inline std::vector<std::string> reload(Server& server) {
  const auto ended = std::make_shared<std::promise<std::vector<std::string>>>();
  server.reload([ended](std::vector<std::string> wrong) { ended->set_value(std::move(wrong)); });
  return ended->get_future().get();
}

}  // namespace feltwire::test
