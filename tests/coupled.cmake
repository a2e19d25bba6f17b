# Tests of coupled runs, one executable a line. They run in this process, through the library.
add_library(coupled_support STATIC support/coupled_pair.cpp support/reduction_case.cpp
  support/truth_case.cpp)
target_link_libraries(coupled_support PUBLIC tandem_options orchestrator PRIVATE fmt::fmt)
target_compile_definitions(coupled_support PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

tandem_test(coupled_unit
  SOURCES unit/advise/candidates.cpp unit/advise/choice.cpp unit/orchestrator/body_rates.cpp
    unit/orchestrator/check_warnings.cpp unit/orchestrator/chosen_settings.cpp
    unit/orchestrator/compare_price.cpp unit/coupled/free_pair.cpp unit/orchestrator/svg_plot.cpp
    unit/orchestrator/system_graph.cpp unit/advise/interface_ratios.cpp unit/fem/newmark_bound.cpp
    unit/coupled/free_chain.cpp
    unit/orchestrator/run_folder.cpp unit/orchestrator/verdict.cpp
  LIBS coupled_support nlohmann_json::nlohmann_json LABELS unit)
tandem_test(coupled_convergence
  SOURCES convergence/coupled_adaptive.cpp convergence/coupled_closed_loop.cpp convergence/coupled_free_pair.cpp convergence/coupled_tumbling.cpp convergence/coupled_orders.cpp
    convergence/coupled_second_order.cpp convergence/coupled_systems.cpp
  LIBS coupled_support LABELS convergence)
tandem_test(coupled_reference
  SOURCES reference/coupled_nodal.cpp reference/coupled_reduction.cpp reference/coupled_slider_crank.cpp reference/coupled_truth.cpp
    reference/coupled_vibration.cpp
  LIBS coupled_support LABELS reference)
tandem_test(coupled_equivalence
  SOURCES equivalence/coupled_bodies.cpp equivalence/coupled_coarse_steps.cpp
    equivalence/coupled_junctions.cpp
    equivalence/coupled_multi_rate.cpp equivalence/coupled_worlds.cpp
    equivalence/coupled_schemes.cpp equivalence/coupled_symmetry.cpp
  LIBS coupled_support nlohmann_json::nlohmann_json LABELS equivalence)

# Measures what nodal coupling costs over the number of nodes: nodal_cost SVG_FILE.
add_executable(nodal_cost bench/nodal_cost.cpp)
target_link_libraries(nodal_cost PRIVATE tandem_options orchestrator fmt::fmt)
add_dependencies(nodal_cost tandem tandem-mbs tandem-fem)

# Draws what modal reduction costs in accuracy, and prints its tables: reduction SVG_FILE.
add_executable(reduction bench/reduction.cpp)
target_link_libraries(reduction PRIVATE coupled_support fmt::fmt)

# Draws the comparison with the reference trajectories: truth_plots [--out DIR].
add_executable(truth_plots bench/truth.cpp)
target_link_libraries(truth_plots PRIVATE coupled_support fmt::fmt)
target_compile_definitions(truth_plots PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# The coupled step beside its parts, in one run: step_parts [--steps N] [--rounds N] [--check FILE].
# The test is short and alone on the machine; it fails where a ratio has doubled.
add_executable(step_parts bench/step_parts.cpp)
target_link_libraries(step_parts PRIVATE tandem_options orchestrator fmt::fmt)
target_compile_definitions(step_parts PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_dependencies(step_parts tandem tandem-mbs tandem-fem)
add_test(NAME StepParts.NoRatioHasDoubled
  COMMAND step_parts --check ${CMAKE_CURRENT_SOURCE_DIR}/bench/step_parts.json)
set_tests_properties(StepParts.NoRatioHasDoubled PROPERTIES LABELS process RUN_SERIAL ON TIMEOUT 300)

# Prints the table of docs/real_time.md: accuracy against a bounded step.
add_executable(budget bench/budget.cpp)
target_link_libraries(budget PRIVATE tandem_options orchestrator fmt::fmt)
target_compile_definitions(budget PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# Measures what several flexible bodies cost against their number: bodies_cost SVG_FILE.
add_executable(bodies_cost bench/bodies_cost.cpp)
target_link_libraries(bodies_cost PRIVATE tandem_options orchestrator fmt::fmt)
target_compile_definitions(bodies_cost PRIVATE TANDEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_dependencies(bodies_cost tandem tandem-mbs tandem-fem)
tandem_test(trace_unit SOURCES unit/orchestrator/clock_fit.cpp unit/orchestrator/critical_path.cpp LIBS orchestrator LABELS unit)
