# feltwire_schema(TARGET file.fbs ...)
# Generates FILE_generated.h (flatc, with the object verifier) and FILE_fbs.hpp (the schema's own text, which the
# JSON parser needs at run time) under generated/<folder>/ and makes TARGET depend on them. Paths are relative to the
# calling folder; include them as "<folder>/<file>_generated.h".
find_program(FELTWIRE_FLATC flatc REQUIRED)

function(feltwire_schema target)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(outputs)
  foreach(schema IN LISTS ARGN)
    get_filename_component(name ${schema} NAME_WE)
    get_filename_component(sub ${schema} DIRECTORY)
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${schema})
    set(out_dir ${PROJECT_BINARY_DIR}/generated/${folder}/${sub})
    file(MAKE_DIRECTORY ${out_dir})
    add_custom_command(
      OUTPUT ${out_dir}/${name}_generated.h
      COMMAND ${FELTWIRE_FLATC} --cpp --cpp-std c++17 --scoped-enums --warnings-as-errors -o ${out_dir} ${source}
      DEPENDS ${source} VERBATIM)
    add_custom_command(
      OUTPUT ${out_dir}/${name}_fbs.hpp
      COMMAND ${CMAKE_COMMAND} -DSCHEMA=${source} -DNAME=${name} -DOUT=${out_dir}/${name}_fbs.hpp
              -P ${PROJECT_SOURCE_DIR}/cmake/embed_schema.cmake
      DEPENDS ${source} ${PROJECT_SOURCE_DIR}/cmake/embed_schema.cmake VERBATIM)
    list(APPEND outputs ${out_dir}/${name}_generated.h ${out_dir}/${name}_fbs.hpp)
  endforeach()
  add_custom_target(${target}_schema DEPENDS ${outputs})
  add_dependencies(${target} ${target}_schema)
endfunction()
