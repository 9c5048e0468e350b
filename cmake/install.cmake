# `cmake --install build/release --prefix DIR`: headers as feltwire/..., two libraries, what find_package(feltwire) and
# pkg-config need. Nothing in it names DIR, so the folder may be moved. docs/linking.md says how to link.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# feltwire_installed(NAME room ...): all objects of the rooms as one library, libfeltwire_NAME.a, feltwire::NAME.
function(feltwire_installed name)
  set(objects)
  foreach(room IN LISTS ARGN)
    string(REPLACE "/" "_" library "feltwire_${room}")
    get_target_property(kind ${library} TYPE)
    if(kind STREQUAL STATIC_LIBRARY)
      list(APPEND objects $<TARGET_OBJECTS:${library}>)
    endif()
  endforeach()
  add_library(feltwire_installed_${name} STATIC ${objects})
  set_target_properties(feltwire_installed_${name} PROPERTIES
    OUTPUT_NAME feltwire_${name} EXPORT_NAME ${name} LINKER_LANGUAGE CXX)
  target_include_directories(feltwire_installed_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(feltwire_installed_${name} INTERFACE cxx_std_20)
  install(TARGETS feltwire_installed_${name} EXPORT feltwire ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
endfunction()

set(core_rooms ${FELTWIRE_THIN_CORE})
set(client_rooms protocol/crypto protocol/fleet protocol/session protocol/wire protocol/net
  client/device client/hands client/input_devices client/drivers/common client/drivers/force_dimension
  client/drivers/open_haptics client/drivers/haply client/drivers/novint client/drivers/joystick client/drivers/plugin
  client/drivers client/transport client/servo core/recording client/run)
if(FELTWIRE_LEFT_OUT)
  list(REMOVE_ITEM client_rooms ${FELTWIRE_LEFT_OUT})
endif()
set(wslay)
set(FELTWIRE_WSLAY_LIB)
if(FELTWIRE_DRIVER_HAPLY)
  set(wslay wslay)
  set(FELTWIRE_WSLAY_LIB " -lwslay")  # Debian's package has no .pc file
endif()
feltwire_installed(core ${core_rooms})
feltwire_installed(client ${client_rooms})
target_link_libraries(feltwire_installed_core INTERFACE Eigen3::Eigen flatbuffers::flatbuffers)
target_link_libraries(feltwire_installed_client INTERFACE feltwire_installed_core OpenSSL::SSL sodium zstd ZLIB::ZLIB
  ${wslay} Threads::Threads)

# The C interface: a library that needs nothing of the others. Debian's packages and the wheel take components (docs/packages.md).
set_target_properties(feltwire PROPERTIES EXPORT_NAME c)
target_include_directories(feltwire INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
install(TARGETS feltwire EXPORT feltwire LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT c NAMELINK_COMPONENT development)
install(FILES client/c_api/feltwire.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(FILES client/c_api/Feltwire.cs DESTINATION ${CMAKE_INSTALL_DATADIR}/feltwire-dev COMPONENT development)
install(FILES sim/own_laws/feltwire_law_v1.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/feltwire/sim/own_laws COMPONENT development)

set(config ${CMAKE_INSTALL_LIBDIR}/cmake/feltwire)
install(EXPORT feltwire NAMESPACE feltwire:: FILE feltwireTargets.cmake DESTINATION ${config} COMPONENT development)
configure_package_config_file(cmake/feltwireConfig.cmake.in ${PROJECT_BINARY_DIR}/feltwireConfig.cmake
  INSTALL_DESTINATION ${config})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/feltwireConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/feltwireConfig.cmake ${PROJECT_BINARY_DIR}/feltwireConfigVersion.cmake
  DESTINATION ${config} COMPONENT development)
file(RELATIVE_PATH FELTWIRE_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/feltwire.pc.in ${PROJECT_BINARY_DIR}/feltwire.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/feltwire.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

install(CODE "
  set(SOURCE ${PROJECT_SOURCE_DIR})
  set(ROOMS ${core_rooms} ${client_rooms})
  set(OUT \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
  include(${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake)" COMPONENT development)
install(TARGETS feltwire-client RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT client)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
