# edvo_read_version(VARIABLE HEADER PARTS): "1.2.3" of three #define lines of a header whose names end in
# PARTS, a regular expression; nothing if the header is not there.
function(edvo_read_version variable header parts)
  set(lines "")
  if(EXISTS ${header})
    file(STRINGS ${header} lines REGEX "#define [A-Z]+_VERSION_(${parts})")
  endif()
  string(REGEX REPLACE "[^0-9;]" "" lines "${lines}")
  string(REPLACE ";" "." lines "${lines}")
  set(${variable} "${lines}" PARENT_SCOPE)
endfunction()
