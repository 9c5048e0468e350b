# Run by `cmake --install`: copies the headers of the rooms ROOMS of SOURCE to OUT/feltwire, with
#   #include "core/..."   written as   #include "feltwire/core/..."
# so that nothing but the folder feltwire/ is added to what a consumer can include. A header that needs a library which only
# our own sources need (Asio, OpenSSL, FlatBuffers, libsodium, nlohmann-json) is internal and stays here, with those that
# include it.
# The headers of devices stood in client/devices in version 0.1. A file there includes the new place, so that such programs compile.
set(headers)
foreach(room IN LISTS ROOMS)
  file(GLOB found RELATIVE ${SOURCE} ${SOURCE}/${room}/*.hpp ${SOURCE}/${room}/*.h)
  list(APPEND headers ${found})
endforeach()

set(internal "<(asio|nlohmann|openssl|flatbuffers|CLI)[/.]|<sodium|\"flatbuffers|\"[^\"]*_generated\\.h\"")
set(before 0)
list(LENGTH headers count)
while(NOT count EQUAL before)
  set(before ${count})
  foreach(header IN LISTS headers)
    file(READ ${SOURCE}/${header} text)
    if(text MATCHES "#include (${internal})")
      list(REMOVE_ITEM headers ${header})
      string(APPEND internal "|\"${header}\"")
    endif()
  endforeach()
  list(LENGTH headers count)
endwhile()

foreach(header IN LISTS headers)
  file(READ ${SOURCE}/${header} text)
  string(REGEX REPLACE "#include \"(core|protocol|client)/" "#include \"feltwire/\\1/" text "${text}")
  file(WRITE ${OUT}/feltwire/${header} "${text}")
  if(header MATCHES "^client/(device|hands|input_devices|drivers)/")
    get_filename_component(name ${header} NAME)
    file(WRITE ${OUT}/feltwire/client/devices/${name} "#include \"feltwire/${header}\"\n")
  endif()
endforeach()
