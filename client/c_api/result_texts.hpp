#pragma once
// clang-format off
// The meaning of each result of the C interface. Written by make_bindings.py from api_table.py. Change the table.

#include <cstdint>

#include "client/c_api/feltwire.h"

namespace feltwire {

inline const char* result_text(std::int32_t result) noexcept {
  switch (result) {
    case FW_OK:
      return "It is done.";
    case FW_NOTHING:
      return "There is nothing yet, or nothing new.";
    case FW_ENDED:
      return "The hand's run, the observer or the follower has ended. fw_last_error() says why, if an error ended it.";
    case FW_ERROR_ARGUMENT:
      return "An argument is null, or an option is wrong. fw_last_error() names it and the remedy.";
    case FW_ERROR_REFUSED:
      return "The server refuses for good: the token, the scene, the device or a parameter.";
    case FW_ERROR_SERVER:
      return "The server is not reachable, not trusted, or full. Trying again may help.";
    case FW_ERROR_DEVICE:
      return "The device or a file cannot be opened.";
    case FW_ERROR_MEMORY:
      return "There is no memory for it.";
    case FW_ERROR_INTERNAL:
      return "Anything else. fw_last_error() has the text.";
    default:
      return "no result of this library";
  }
}

}  // namespace feltwire
