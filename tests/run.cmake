# Tests of the executables tandem, tandem-mbs and tandem-fem as users start them.
foreach(example lug two_masses pendulum_beam slider_crank)
  if(EXISTS ${PROJECT_SOURCE_DIR}/examples/${example}/scenario.yaml)
    list(APPEND examples "\"${example}\"")
  endif()
endforeach()
list(JOIN examples "," examples)

function(tandem_run_test name source labels)
  tandem_test(${name} SOURCES ${source} LIBS tandem_wire lcm::lcm nlohmann_json::nlohmann_json LABELS ${labels}
    ${ARGN})
  add_dependencies(${name} tandem tandem-mbs tandem-fem tandem_fault_shim)
  target_compile_definitions(${name} PRIVATE TANDEM_EXAMPLES=${examples}
    TANDEM_FAULT_SHIM="$<TARGET_FILE:tandem_fault_shim>")
endfunction()

tandem_run_test(run_report process/run_report.cpp process)
tandem_run_test(run_same_bits process/run_same_bits.cpp "process;equivalence")
tandem_run_test(run_bench process/run_bench.cpp process)
tandem_run_test(run_energy process/run_energy.cpp "process;reference")
tandem_run_test(run_environment process/run_environment.cpp process)
tandem_run_test(run_failures process/run_failures.cpp process)
tandem_run_test(run_command_line process/run_command_line.cpp process)
tandem_run_test(run_input process/run_input.cpp process)
tandem_run_test(run_compare process/run_compare.cpp process)
tandem_run_test(run_advise process/run_advise.cpp process PROPERTIES TIMEOUT 900)
tandem_run_test(run_control process/run_control.cpp process)
tandem_run_test(run_log process/run_log.cpp process)
tandem_run_test(run_verdict process/run_verdict.cpp process)
tandem_run_test(run_strangers process/run_strangers.cpp process)
tandem_run_test(ancf_same_bits process/ancf_same_bits.cpp "process;equivalence")
# The longest test: begins first.
tandem_run_test(ancf_drive process/ancf_drive.cpp "process;equivalence;reference" PROPERTIES COST 1000)
target_link_libraries(ancf_drive PRIVATE fem)
