// This file compiles the non-template functions of Asio once, instead of in every file that
// includes Asio (ASIO_SEPARATE_COMPILATION). The functions are weak symbols, because a program that
// links feltwire's libraries may have its own Asio, compiled in another way.
#define ASIO_DECL __attribute__((weak))

#include <asio/impl/src.hpp>
#include <asio/ssl/impl/src.hpp>
