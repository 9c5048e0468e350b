#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/support/temporary_folder.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::testing {

using test::TemporaryFolder;
using test::text_of;

/// The text of the Error that `action` throws. Empty, and the test fails, if it throws nothing.
template <class Error, class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace feltwire::testing
