# Tests of the beams and tracks of the flexible side, one executable a line.
tandem_test(ancf_unit SOURCES unit/ancf/connections.cpp unit/ancf/contact.cpp unit/ancf/element.cpp LIBS fem LABELS unit)
tandem_test(ancf_reference SOURCES reference/ancf_dynamics.cpp reference/ancf_rings.cpp reference/ancf_statics.cpp LIBS fem LABELS reference)
tandem_test(ancf_contract SOURCES contract/ancf_contract.cpp LIBS fem LABELS contract)

add_library(beam_support STATIC support/beam_pair.cpp)
target_link_libraries(beam_support PUBLIC tandem_options orchestrator)
target_compile_definitions(beam_support PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
tandem_test(ancf_attachment SOURCES reference/ancf_attachment.cpp LIBS beam_support LABELS reference)
tandem_test(ancf_vehicle SOURCES reference/ancf_belt.cpp reference/ancf_vehicle.cpp LIBS beam_support LABELS reference)
tandem_test(ancf_command SOURCES process/ancf_command.cpp LIBS orchestrator fmt::fmt LABELS process)

# The whole run of the vehicle with Figures 4 to 8 of [JC11]; regenerates docs/figures/vehicle.svg.
add_executable(vehicle_figures bench/vehicle.cpp)
target_link_libraries(vehicle_figures PRIVATE beam_support fmt::fmt)
target_compile_definitions(vehicle_figures PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
# The largest macro step with each scheme; regenerates the table of docs/tracked_vehicle.md.
add_executable(vehicle_stability bench/vehicle_stability.cpp)
target_link_libraries(vehicle_stability PRIVATE beam_support fmt::fmt)
target_compile_definitions(vehicle_stability PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
tandem_test(ancf_order SOURCES convergence/ancf_order.cpp LIBS beam_support LABELS convergence)
