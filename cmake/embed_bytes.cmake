# Writes the bytes of SOURCE as a C++ constant: feltwire::embedded::NAME.
file(READ ${SOURCE} bytes HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REGEX REPLACE "((....,)(....,)(....,)(....,)(....,)(....,)(....,)(....,))" "\\1\n" bytes "${bytes}")
file(WRITE ${OUT} "#pragma once
namespace feltwire::embedded {
inline constexpr unsigned char ${NAME}[] = {
${bytes}};
}  // namespace feltwire::embedded
")
