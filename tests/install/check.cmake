# Installs BUILD into a fresh prefix, then configures, builds and runs CONSUMER against it. Any failure fails the test.
set(work ${BUILD}/install_check)
file(REMOVE_RECURSE ${work})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
foreach(wanted include/jaculus share/jaculus/models share/jaculus/problems)
  if(NOT EXISTS ${work}/prefix/${wanted})
    message(FATAL_ERROR "${wanted} was not installed")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${work}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${work}/prefix -DSANITIZE=${SANITIZE})
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/consumer ${work})
file(REMOVE_RECURSE ${work})
