# ninja tidy: clang-tidy over every source file of this build; .clang-tidy says which checks.
find_program(EDVO_RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy)
if(EDVO_RUN_CLANG_TIDY)
  add_custom_target(tidy
    COMMAND ${EDVO_RUN_CLANG_TIDY} -quiet -p ${CMAKE_BINARY_DIR}
            "^${PROJECT_SOURCE_DIR}/(src|apps|tests|benchmarks)/"
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    USES_TERMINAL)
endif()
