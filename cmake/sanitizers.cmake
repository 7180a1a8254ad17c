# EDVO_SANITIZE=address,undefined (or thread) builds everything with these sanitizers of gcc or clang.
set(EDVO_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined")
if(EDVO_SANITIZE)
  add_compile_options(-fsanitize=${EDVO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${EDVO_SANITIZE})
endif()
