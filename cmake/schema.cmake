# Generated headers, under generated/<folder of the source>/ in the build tree.
find_program(FELTWIRE_FLATC flatc REQUIRED)

# feltwire_embed(TARGET file ...): FILE_text.hpp with the file's text as feltwire::embedded::FILE.
# Files are absolute paths inside the project; include them as "<folder>/<file>_text.hpp".
function(feltwire_embed target)
  set(outputs)
  foreach(source IN LISTS ARGN)
    file(RELATIVE_PATH relative ${PROJECT_SOURCE_DIR} ${source})
    get_filename_component(name ${relative} NAME_WE)
    get_filename_component(folder ${relative} DIRECTORY)
    set(out ${PROJECT_BINARY_DIR}/generated/${folder}/${name}_text.hpp)
    file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/generated/${folder})
    add_custom_command(
      OUTPUT ${out}
      COMMAND ${CMAKE_COMMAND} -DSOURCE=${source} -DNAME=${name} -DOUT=${out}
              -P ${PROJECT_SOURCE_DIR}/cmake/embed_text.cmake
      DEPENDS ${source} ${PROJECT_SOURCE_DIR}/cmake/embed_text.cmake VERBATIM)
    list(APPEND outputs ${out})
  endforeach()
  add_custom_target(${target}_embedded DEPENDS ${outputs})
  add_dependencies(${target} ${target}_embedded)
endfunction()

# feltwire_schema(TARGET file.fbs ...): FILE_generated.h (flatc). Paths relative to the calling folder; include them as
# "<folder>/<file>_generated.h".
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
    list(APPEND outputs ${out_dir}/${name}_generated.h)
  endforeach()
  add_custom_target(${target}_schema DEPENDS ${outputs})
  add_dependencies(${target} ${target}_schema)
endfunction()

# feltwire_descriptors(TARGET file.proto ...): FILE_descriptors.hpp with what protoc says of the file and of all that it
# imports (a FileDescriptorSet) as feltwire::embedded::FILE_descriptors. Paths as of feltwire_schema().
function(feltwire_descriptors target)
  find_program(FELTWIRE_PROTOC protoc REQUIRED)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(outputs)
  foreach(proto IN LISTS ARGN)
    get_filename_component(name ${proto} NAME_WE)
    get_filename_component(sub ${proto} DIRECTORY)
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${proto})
    get_filename_component(root ${source} DIRECTORY)
    set(out ${PROJECT_BINARY_DIR}/generated/${folder}/${sub}/${name}_descriptors)
    file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/generated/${folder}/${sub})
    file(GLOB_RECURSE imported ${root}/*.proto)
    add_custom_command(
      OUTPUT ${out}.hpp
      COMMAND ${FELTWIRE_PROTOC} -I${root} --include_imports --descriptor_set_out=${out}.bin ${source}
      COMMAND ${CMAKE_COMMAND} -DSOURCE=${out}.bin -DNAME=${name}_descriptors -DOUT=${out}.hpp
              -P ${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake
      DEPENDS ${imported} ${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake VERBATIM)
    list(APPEND outputs ${out}.hpp)
  endforeach()
  add_custom_target(${target}_descriptors DEPENDS ${outputs})
  add_dependencies(${target} ${target}_descriptors)
endfunction()
