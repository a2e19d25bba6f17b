# Tests of fem, one executable a line.
tandem_test(fem_unit
  SOURCES unit/fem/amplification.cpp unit/fem/body.cpp unit/fem/columns.cpp unit/fem/commands.cpp unit/fem/element.cpp unit/fem/formulations.cpp unit/fem/interface_jacobian.cpp unit/fem/keys.cpp
    unit/fem/materials.cpp unit/fem/micro_steps.cpp unit/fem/nearby_solver.cpp unit/fem/momentum.cpp unit/fem/quasi_static.cpp unit/fem/solvers.cpp unit/fem/tet10.cpp
    unit/fem/vtu.cpp unit/fem/tet10_lanes.cpp
  LIBS fem LABELS unit)
tandem_test(fem_mesh
  SOURCES unit/fem/decks.cpp unit/fem/gmsh_formats.cpp unit/fem/mesh.cpp unit/fem/mesh_mutations.cpp
    unit/fem/tet10_mesh.cpp
  LIBS fem LABELS unit)
# Several of these have meshes and helpers of the same names.
set_target_properties(fem_mesh PROPERTIES UNITY_BUILD OFF)
tandem_test(fem_ports SOURCES unit/fem/port_jacobian.cpp unit/fem/port_refusals.cpp unit/fem/port_relations.cpp unit/fem/ports.cpp LIBS fem LABELS unit)
tandem_test(fem_energy SOURCES unit/fem/energy.cpp LIBS fem LABELS unit)
tandem_test(fem_speed SOURCES unit/fem/multigrid.cpp unit/fem/speed.cpp LIBS fem LABELS unit)
tandem_test(fem_reduced SOURCES unit/fem/floating_frame.cpp unit/fem/reduction.cpp LIBS fem LABELS unit)
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
