# Tests of protocol_schemes, one executable a line.
tandem_test(test_schemes
  SOURCES unit/schemes/accelerator.cpp unit/schemes/adaptive.cpp unit/schemes/beyond_tolerance.cpp unit/schemes/explicit_parallel.cpp
    unit/schemes/body_blocks.cpp unit/schemes/composite_side.cpp unit/schemes/counter_inertia.cpp
    unit/schemes/jacobian_block.cpp unit/schemes/options.cpp unit/schemes/pace.cpp unit/schemes/prediction.cpp unit/schemes/scale.cpp unit/schemes/schemes.cpp
  LIBS tandem_driver tandem_schemes
  LABELS unit)
tandem_test(schemes_convergence
  SOURCES convergence/schemes_order.cpp
  LIBS tandem_driver tandem_schemes
  LABELS convergence)

# Prints the tables of iterations and stability of docs/coupling.md.
add_executable(coupling_sweep bench/coupling_sweep.cpp)
target_link_libraries(coupling_sweep PRIVATE tandem_options tandem_driver tandem_schemes fmt::fmt)
