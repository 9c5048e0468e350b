// The functions of Asio that are no templates, compiled here once instead of in every file that
// includes Asio (ASIO_SEPARATE_COMPILATION). They are weak: a program that links feltwire's
// libraries may bring an Asio of its own, compiled in its own way.
#define ASIO_DECL __attribute__((weak))

#include <asio/impl/src.hpp>
#include <asio/ssl/impl/src.hpp>
