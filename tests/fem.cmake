# Tests of fem, one executable a line.
tandem_test(fem_unit
  SOURCES unit/fem_amplification.cpp unit/fem_body.cpp unit/fem_columns.cpp unit/fem_commands.cpp unit/fem_element.cpp unit/fem_formulations.cpp unit/fem_interface_jacobian.cpp unit/fem_keys.cpp
    unit/fem_materials.cpp unit/fem_mesh.cpp unit/fem_micro_steps.cpp unit/fem_nearby_solver.cpp unit/fem_momentum.cpp unit/fem_quasi_static.cpp unit/fem_solvers.cpp unit/fem_tet10.cpp
    unit/fem_tet10_mesh.cpp unit/fem_vtu.cpp unit/fem_tet10_lanes.cpp
  LIBS fem LABELS unit)
tandem_test(fem_ports SOURCES unit/fem_port_jacobian.cpp unit/fem_port_refusals.cpp unit/fem_port_relations.cpp unit/fem_ports.cpp LIBS fem LABELS unit)
tandem_test(fem_energy SOURCES unit/fem_energy.cpp LIBS fem LABELS unit)
tandem_test(fem_speed SOURCES unit/fem_multigrid.cpp unit/fem_speed.cpp LIBS fem LABELS unit)
tandem_test(fem_reduced SOURCES unit/fem_floating_frame.cpp unit/fem_reduction.cpp LIBS fem LABELS unit)
tandem_test(fem_contract SOURCES contract/fem_contract.cpp contract/fem_reduced_contract.cpp LIBS fem LABELS contract)
tandem_test(fem_reference
  SOURCES reference/fem_materials_reference.cpp reference/fem_modes.cpp reference/fem_reference.cpp reference/fem_statics.cpp
    reference/fem_rotor.cpp reference/fem_tet10_reference.cpp reference/fem_transient.cpp reference/fem_turning.cpp
    reference/fem_turning_crank.cpp support/fem_reference_cases.cpp
  LIBS fem LABELS reference)
tandem_test(fem_command SOURCES process/fem_command.cpp LIBS orchestrator LABELS process)
tandem_test(fem_convergence SOURCES convergence/fem_mesh_size.cpp convergence/fem_order.cpp LIBS fem LABELS convergence)

# Regenerates docs/figures/figure4.svg and the tables of docs/fem.md.
add_executable(figure4 bench/figure4.cpp support/fem_reference_cases.cpp)
target_link_libraries(figure4 PRIVATE tandem_options orchestrator fmt::fmt)
target_compile_definitions(figure4 PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# Times of one step, for profilers; no test.
find_package(benchmark REQUIRED)
add_executable(fem_step bench/fem_step.cpp)
target_link_libraries(fem_step PRIVATE tandem_options fem benchmark::benchmark)
target_compile_definitions(fem_step PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
