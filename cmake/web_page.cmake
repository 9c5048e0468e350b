# The live page of the server, bundled from server/web/page by npm's packages, whose hashes package-lock.json pins.
find_program(FELTWIRE_NODE node)
find_program(FELTWIRE_NPM npm)
if(FELTWIRE_NODE AND FELTWIRE_NPM)
  option(FELTWIRE_WEB "Compile the live page into the server" ON)
else()
  option(FELTWIRE_WEB "Compile the live page into the server" OFF)
  if(NOT FELTWIRE_WEB)
    message(STATUS "The server is built without its live page: npm was not found. Install the Debian packages nodejs and npm.")
  endif()
endif()

# feltwire_web_page(TARGET): adds the files of the page to TARGET, which then defines page_assets() (server/web/page_assets.hpp).
# Without FELTWIRE_WEB there are none.
function(feltwire_web_page target)
  set(source ${PROJECT_SOURCE_DIR}/server/web/page)
  set(copy ${PROJECT_BINARY_DIR}/page)
  set(assets ${copy}/page_assets.cpp)
  if(FELTWIRE_WEB)
    if(NOT FELTWIRE_NODE OR NOT FELTWIRE_NPM)
      message(FATAL_ERROR "FELTWIRE_WEB needs node and npm. Install the Debian packages nodejs and npm, or set FELTWIRE_WEB=OFF.")
    endif()
    set(packages ${source}/package.json ${source}/package-lock.json)
    file(GLOB modules CONFIGURE_DEPENDS ${source}/src/*.js ${source}/src/replay/*.js)
    file(GLOB styles CONFIGURE_DEPENDS ${source}/*.css)
    set(files ${source}/build.mjs ${source}/index.html ${source}/icon.svg ${styles})
    add_custom_command(
      OUTPUT ${copy}/node_modules/.package-lock.json
      COMMAND ${CMAKE_COMMAND} -E make_directory ${copy}
      COMMAND ${CMAKE_COMMAND} -E copy ${packages} ${copy}
      # No script of a package runs.
      COMMAND ${FELTWIRE_NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
      COMMAND ${CMAKE_COMMAND} -E touch ${copy}/node_modules/.package-lock.json
      DEPENDS ${packages} WORKING_DIRECTORY ${copy} COMMENT "Installing the live page's packages from npm's registry (-DFELTWIRE_WEB=OFF does without)" VERBATIM)
    add_custom_command(
      OUTPUT ${assets}
      BYPRODUCTS ${copy}/feltwire-replay.html
      COMMAND ${CMAKE_COMMAND} -E rm -rf ${copy}/src
      COMMAND ${CMAKE_COMMAND} -E copy_directory ${source}/src ${copy}/src
      COMMAND ${CMAKE_COMMAND} -E copy ${files} ${copy}
      COMMAND ${FELTWIRE_NODE} build.mjs .
      DEPENDS ${modules} ${files} ${copy}/node_modules/.package-lock.json
      WORKING_DIRECTORY ${copy} COMMENT "Bundling the live page" VERBATIM)
    file(MAKE_DIRECTORY ${copy})
  else()
    set(assets ${copy}/no_page_assets.cpp)
    file(CONFIGURE OUTPUT ${assets} @ONLY CONTENT "#include \"server/web/page_assets.hpp\"\n
std::span<const feltwire::PageAsset> feltwire::page_assets() noexcept { return {}; }\n")
  endif()
  set_source_files_properties(${assets} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_sources(${target} PRIVATE ${assets})
endfunction()
