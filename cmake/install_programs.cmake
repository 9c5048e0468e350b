# The programs, the scenes, and the page that shows recordings, each with the component of the package that it belongs to:
#   cmake --install build/release --prefix DIR [--component server]
# bin/feltwire-mjcf reads MJCF files for the programs beside it.
foreach(component server view follower lab)
  install(TARGETS feltwire-${component} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
endforeach()
# The directory of a fleet, which a server loads: cmake --install build/release --component fleet.
if(TARGET feltwire-nats)
  install(TARGETS feltwire-nats LIBRARY DESTINATION lib/feltwire COMPONENT fleet EXCLUDE_FROM_ALL)
endif()
install(TARGETS feltwire-mjcf RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT common)
install(PROGRAMS ${PROJECT_BINARY_DIR}/bin/feltwire-bundle DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT server)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/feltwire COMPONENT common)
if(FELTWIRE_WEB)
  install(FILES ${PROJECT_BINARY_DIR}/page/feltwire-replay.html DESTINATION ${CMAKE_INSTALL_DATADIR}/feltwire COMPONENT common)
endif()
