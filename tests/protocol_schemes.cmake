# Tests of protocol_schemes, one executable a line.
tandem_test(test_schemes
  SOURCES unit/schemes_accelerator.cpp unit/schemes_adaptive.cpp unit/schemes_beyond_tolerance.cpp unit/schemes_explicit_parallel.cpp
    unit/schemes_jacobian_block.cpp unit/schemes_options.cpp unit/schemes_pace.cpp unit/schemes_prediction.cpp unit/schemes_scale.cpp unit/schemes_test.cpp
  LIBS tandem_driver tandem_schemes
  LABELS unit)
tandem_test(schemes_convergence
  SOURCES convergence/schemes_order.cpp
  LIBS tandem_driver tandem_schemes
  LABELS convergence)

# Prints the tables of iterations and stability of docs/coupling.md.
add_executable(coupling_sweep bench/coupling_sweep.cpp)
target_link_libraries(coupling_sweep PRIVATE tandem_options tandem_driver tandem_schemes fmt::fmt)
