# Writes feltwire::generated::kCommit, the commit of the checkout SOURCE, to OUT, where it is another than OUT has. Sources without a
# checkout have it in the file commit.txt (scripts/package).
find_program(GIT git)
set(commit unknown)
if(GIT AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --abbrev=12 --dirty --exclude=*
                  OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(commit ${described})
  endif()
elseif(EXISTS ${SOURCE}/commit.txt)
  file(STRINGS ${SOURCE}/commit.txt commit LIMIT_COUNT 1)
endif()
set(text "#pragma once
namespace feltwire::generated {
inline constexpr const char* kCommit = \"${commit}\";
}  // namespace feltwire::generated
")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
