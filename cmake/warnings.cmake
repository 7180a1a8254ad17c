function(edvo_set_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    -Wno-sign-conversion  # Eigen and OpenCV index with signed integers, the standard library with unsigned
    -Wno-deprecated-enum-enum-conversion  # raised by OpenCV 4.6 headers under C++20
    -Wno-missing-field-initializers  # designated initializers leave the rest at their defaults
    # A loop that clang leaves scalar is slower, not wrong.
    $<$<CXX_COMPILER_ID:Clang>:-Wno-pass-failed>
    # False alarms of gcc 12, on Eigen's comma initialisation and on std::string.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-restrict>)
  if(EDVO_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()
