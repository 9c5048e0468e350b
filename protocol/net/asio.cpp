// The non-template functions of Asio, compiled here once instead of in every file that
// includes Asio (ASIO_SEPARATE_COMPILATION). They are weak: a program that links feltwire's
// libraries may have its own Asio, compiled in another way.
#define ASIO_DECL __attribute__((weak))

#include <asio/impl/src.hpp>
#include <asio/ssl/impl/src.hpp>
