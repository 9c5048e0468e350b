# FELTWIRE_SELF_CONTAINED: for systems that do not have this machine's libraries (scripts/package, the Python wheel). All that has
# an archive here is linked statically. What has none (MuJoCo and what it needs, spdlog, fmt, wslay) must lie in lib/ beside bin/.
option(FELTWIRE_SELF_CONTAINED "Link the libraries of this machine statically, for use on others" OFF)

if(NOT FELTWIRE_SELF_CONTAINED)
  set(FELTWIRE_FLATBUFFERS flatbuffers::flatbuffers_shared)
  function(feltwire_own_cxx_library target)
  endfunction()
  return()
endif()

set(FELTWIRE_FLATBUFFERS flatbuffers::flatbuffers)
foreach(name ssl crypto sodium zstd z)
  find_library(FELTWIRE_STATIC_${name} lib${name}.a REQUIRED)
endforeach()
set(FELTWIRE_SODIUM ${FELTWIRE_STATIC_sodium})
set(FELTWIRE_ZSTD ${FELTWIRE_STATIC_zstd})
set_target_properties(OpenSSL::SSL PROPERTIES IMPORTED_LOCATION ${FELTWIRE_STATIC_ssl})
set_target_properties(OpenSSL::Crypto PROPERTIES IMPORTED_LOCATION ${FELTWIRE_STATIC_crypto})
set_target_properties(ZLIB::ZLIB PROPERTIES IMPORTED_LOCATION_RELEASE ${FELTWIRE_STATIC_z})
# DT_RPATH, which unlike DT_RUNPATH also finds the libraries that a library in lib/ needs.
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
set(CMAKE_INSTALL_RPATH $ORIGIN/../lib)
add_link_options(LINKER:--disable-new-dtags)

# feltwire_own_cxx_library(TARGET): the C++ library becomes a part of TARGET, which may use no other library in C++. Programs of any
# compiler can load it then.
function(feltwire_own_cxx_library target)
  target_link_options(${target} PRIVATE -static-libstdc++ -static-libgcc)
  target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/arc4random.cpp)
endfunction()
