# Installs BUILD into a fresh prefix, then configures, builds and runs CONSUMER and the programs of EXAMPLES against it. Any
# failure fails the test.
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
function(build source folder)
  run(${CMAKE_COMMAND} -S ${source} -B ${folder} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
      -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${work}/prefix -DSANITIZE=${SANITIZE})
  run(${CMAKE_COMMAND} --build ${folder})
endfunction()

build(${CONSUMER} ${work}/build)
run(${work}/build/consumer ${work})

# Each example does what its first lines promise.
function(expect wanted)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0 OR NOT output MATCHES "${wanted}")
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}: exit code ${status}, expected '${wanted}' in\n${output}")
  endif()
endfunction()

build(${EXAMPLES} ${work}/examples)
expect("verification passed" ${work}/examples/solve ${EXAMPLES}/hopper/jump.yaml ${work}/torques.csv)
if(NOT EXISTS ${work}/torques.csv)
  message(FATAL_ERROR "the example solve wrote no torques")
endif()
expect("active: [^\n]*pitch rate" ${work}/examples/own_term ${EXAMPLES}/own_term/jump.yaml)
expect("verdict: effect.*viscous_friction" ${work}/examples/diagnose
       ${work}/prefix/share/jaculus/problems/pendulum_trials.yaml joint_viscous_friction:coefficient=0.05)
file(REMOVE_RECURSE ${work})
