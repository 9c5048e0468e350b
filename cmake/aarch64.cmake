# The toolchain for arm64 machines (Raspberry Pi 4 and 5, Jetson) on another Debian 12: scripts/build-aarch64 brings it along.
# FELTWIRE_CROSS is its folder: tools/ has the compiler and qemu, sysroot/ the libraries of the target.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(FELTWIRE_CROSS "" CACHE PATH "Folder that scripts/build-aarch64 has filled")
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FELTWIRE_CROSS)
if(NOT EXISTS ${FELTWIRE_CROSS}/sysroot/usr/include)
  message(FATAL_ERROR "FELTWIRE_CROSS is '${FELTWIRE_CROSS}', which has no sysroot; run scripts/build-aarch64")
endif()
set(CMAKE_C_COMPILER ${FELTWIRE_CROSS}/tools/usr/bin/aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER ${FELTWIRE_CROSS}/tools/usr/bin/aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT ${FELTWIRE_CROSS}/sysroot)
set(CMAKE_CROSSCOMPILING_EMULATOR ${FELTWIRE_CROSS}/tools/usr/bin/qemu-aarch64-static -L ${CMAKE_SYSROOT})
# flatc and protoc are this machine's, all that is linked the target's.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
