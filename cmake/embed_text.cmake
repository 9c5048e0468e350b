# Writes the text of SOURCE as a C++ string constant: feltwire::embedded::NAME.
file(READ ${SOURCE} text)
file(WRITE ${OUT} "#pragma once
namespace feltwire::embedded {
inline constexpr const char* ${NAME} = R\"__text__(${text})__text__\";
}  // namespace feltwire::embedded
")
