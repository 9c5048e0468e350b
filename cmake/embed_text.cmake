# Writes the text of SCHEMA as a C++ string constant: feltwire::schema_text::NAME.
file(READ ${SCHEMA} text)
file(WRITE ${OUT} "#pragma once
namespace feltwire::schema_text {
inline constexpr const char* ${NAME} = R\"__fbs__(${text})__fbs__\";
}  // namespace feltwire::schema_text
")
