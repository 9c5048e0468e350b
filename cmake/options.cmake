# A compiler cache, where there is one: it answers with the same bits that the compiler would give, whatever folder the
# checkout lies in.
find_program(FELTWIRE_CCACHE ccache)
if(FELTWIRE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      ${FELTWIRE_CCACHE})
endif()

# Compiler settings of our own targets: each links feltwire_options with PRIVATE, so that a
# program that links a library of ours keeps its own settings.
add_library(feltwire_options INTERFACE)
target_compile_options(feltwire_options INTERFACE
  -Wall -Wextra -Wpedantic $<$<BOOL:${FELTWIRE_WERROR}>:-Werror> -Wshadow -Wconversion -Wno-sign-conversion
  # Determinism: the same inputs give the same bits, so no contraction into fused multiply-adds.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms on std::string concatenation (GCC bug 105651, mended in 13).
  target_compile_options(feltwire_options INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_UNITY_BUILD)
  # A file that is joined to others is taken for a header, whose types may have no members of an anonymous namespace.
  target_compile_options(feltwire_options INTERFACE -Wno-subobject-linkage)
endif()
target_include_directories(feltwire_options INTERFACE ${PROJECT_SOURCE_DIR})
# Do not warn about code that flatc wrote.
target_include_directories(feltwire_options SYSTEM INTERFACE ${PROJECT_BINARY_DIR}/generated)
set(FELTWIRE_SANITIZE_TESTS ${FELTWIRE_SANITIZE})
set(FELTWIRE_ROOMS_AS STATIC)
# libfeltwire.so (client/c_api) has the rooms' objects in it. No other library replaces their functions, so the compiler may
# inline them as in a program.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(feltwire_options INTERFACE -fno-semantic-interposition)
endif()
if(FELTWIRE_FUZZ)
  # Coverage that libFuzzer is led by; a fuzz target links its main beside (tests/fuzz).
  set(FELTWIRE_SANITIZE "fuzzer-no-link,address,undefined,float-cast-overflow")
  # In a test's own code AddressSanitizer alone looks, by calls: that takes half the time to compile.
  set(FELTWIRE_SANITIZE_TESTS "address;-fsanitize-address-outline-instrumentation")
endif()
if(FELTWIRE_SANITIZE)
  # A room is a shared library that takes its own copies of inline functions. From an archive, the linker would take those of a
  # program or a test, which are not optimized, as are the rooms that neither a servo nor a scene waits for.
  set(FELTWIRE_ROOMS_AS SHARED)
  string(APPEND CMAKE_SHARED_LINKER_FLAGS " -Wl,-Bsymbolic-functions")
  set(unhurried client/app client/command_line client/run gateway/app gateway/remote_scene server/access server/app server/control
    server/recording server/web client/follower_app sim/replay)
  list(TRANSFORM unhurried PREPEND feltwire_)
  string(REPLACE "/" "_" unhurried "${unhurried}")
  set(program $<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>)
  target_compile_options(feltwire_options INTERFACE
    "$<$<OR:${program},$<IN_LIST:$<TARGET_PROPERTY:NAME>,${unhurried}>>:-O0>")
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang" AND FELTWIRE_SANITIZE MATCHES "undefined")
    target_compile_options(feltwire_options INTERFACE
      -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/cmake/sanitizer_ignore.txt)
  endif()
  set(test $<BOOL:$<TARGET_PROPERTY:FELTWIRE_TEST>>)
  target_compile_options(feltwire_options INTERFACE
    "$<$<NOT:${test}>:-fsanitize=${FELTWIRE_SANITIZE}>" "$<${test}:-fsanitize=${FELTWIRE_SANITIZE_TESTS}>"
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(feltwire_options INTERFACE -fsanitize=${FELTWIRE_SANITIZE})
  target_compile_definitions(feltwire_options INTERFACE FELTWIRE_SANITIZED)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND FELTWIRE_SANITIZE MATCHES "thread")
    # Asio has fences that the thread sanitizer does not see; its queues are ordered by mutexes that it does.
    target_compile_options(feltwire_options INTERFACE -Wno-tsan)
  endif()
endif()

# All files that include Asio get the same set. Asio uses aligned_alloc only in files where a standard header came before it, so
# memory of one kind would be given back as the other: nobody uses it then.
# protocol/net/asio.cpp compiles Asio's functions once: to read and compile them in every file that includes Asio takes a fifth of
# the time of such a file.
set(FELTWIRE_ASIO_DEFINITIONS ASIO_STANDALONE ASIO_SEPARATE_COMPILATION ASIO_NO_DEPRECATED ASIO_DISABLE_STD_ALIGNED_ALLOC)
