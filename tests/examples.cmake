# edvo installed to a fresh folder, then each example built against it and run, as a user would.
set(installed ${CMAKE_BINARY_DIR}/install)
set(example_runs ${CMAKE_BINARY_DIR}/example-runs)

add_test(NAME install.clean COMMAND ${CMAKE_COMMAND} -E rm -rf ${installed} ${example_runs})
add_test(NAME install COMMAND ${CMAKE_COMMAND} --install ${CMAKE_BINARY_DIR} --prefix ${installed})
add_test(NAME install.run COMMAND ${installed}/bin/edvo config)
set_tests_properties(install.clean PROPERTIES FIXTURES_SETUP clean_install)
set_tests_properties(install PROPERTIES FIXTURES_REQUIRED clean_install FIXTURES_SETUP installed)
set_tests_properties(install.run PROPERTIES FIXTURES_REQUIRED installed)

add_test(NAME install.sequence
         COMMAND ${installed}/bin/edvo synth ${example_runs}/sequence --frames 30 --size 320x240)
set_tests_properties(install.sequence PROPERTIES FIXTURES_REQUIRED installed
                                                 FIXTURES_SETUP sequence)

set(example_flags "${CMAKE_CXX_FLAGS}")
if(EDVO_SANITIZE)
  string(APPEND example_flags " -fsanitize=${EDVO_SANITIZE}")
endif()

# edvo_add_example(FOLDER PROGRAM FIXTURE ARGUMENT...): needs the fixture, and sets up FOLDER.
function(edvo_add_example folder program fixture)
  add_test(NAME example.${folder}
           COMMAND ${CMAKE_CTEST_COMMAND}
             --build-and-test ${PROJECT_SOURCE_DIR}/examples/${folder}
                              ${CMAKE_BINARY_DIR}/examples/${folder}
             --build-generator ${CMAKE_GENERATOR}
             --build-options -DCMAKE_PREFIX_PATH=${installed} -DCMAKE_BUILD_TYPE=Release
                             -DCMAKE_CXX_FLAGS=${example_flags}
                             -DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}
             --test-command ${program} ${ARGN})
  set_tests_properties(example.${folder} PROPERTIES FIXTURES_REQUIRED ${fixture}
                                                    FIXTURES_SETUP ${folder})
endfunction()

edvo_add_example(01_track_folder track_folder sequence
                 ${example_runs}/sequence ${example_runs}/trajectory.tum)
edvo_add_example(02_own_camera own_camera installed)
edvo_add_example(03_evaluate evaluate 01_track_folder
                 ${example_runs}/sequence/groundtruth.txt ${example_runs}/trajectory.tum)

# What a program that links edvo::odometry alone loads: Eigen has no library, and of OpenCV two parts.
add_test(NAME install.odometry_alone
         COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/scripts/loads_only.sh
                 ${CMAKE_BINARY_DIR}/examples/02_own_camera/own_camera opencv_core opencv_imgproc)
set_tests_properties(install.odometry_alone PROPERTIES FIXTURES_REQUIRED 02_own_camera)

# All headers that a user may include: what they include was installed too.
get_property(public_headers GLOBAL PROPERTY edvo_public_headers)
list(JOIN public_headers "\n" public_headers)
file(WRITE ${CMAKE_BINARY_DIR}/public_headers.txt "${public_headers}\n")
add_test(NAME install.headers
         COMMAND ${CMAKE_CTEST_COMMAND}
           --build-and-test ${CMAKE_CURRENT_SOURCE_DIR}/headers ${CMAKE_BINARY_DIR}/headers
           --build-generator ${CMAKE_GENERATOR}
           --build-options -DCMAKE_PREFIX_PATH=${installed} -DCMAKE_BUILD_TYPE=Debug
                           -DHEADERS=${CMAKE_BINARY_DIR}/public_headers.txt
                           -DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER})
set_tests_properties(install.headers PROPERTIES FIXTURES_REQUIRED installed)

# The library as shared objects, installed, and the example of edvo::odometry against it.
if(NOT BUILD_SHARED_LIBS AND NOT EDVO_SANITIZE)
  add_test(NAME shared
           COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/scripts/shared_build.sh ${PROJECT_SOURCE_DIR}
                   ${CMAKE_BINARY_DIR}-shared ${CMAKE_CXX_COMPILER})
endif()
