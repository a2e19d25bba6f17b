# Tests of mbs, one executable a line.
tandem_test(test_mbs
  SOURCES unit/mbs/drift.cpp unit/mbs/energy.cpp unit/mbs/keys.cpp unit/mbs/motion.cpp
    unit/mbs/motors.cpp unit/mbs/params.cpp unit/mbs/softness.cpp unit/mbs/springs.cpp
    unit/mbs/state.cpp unit/mbs/stops.cpp unit/mbs/wrench_rule.cpp
  LIBS mbs
  LABELS unit)
tandem_test(test_mbs_contract
  SOURCES contract/mbs_jacobian_test.cpp contract/mbs_response_test.cpp
    contract/mbs_rollback_test.cpp
  LIBS mbs
  LABELS contract)
tandem_test(test_mbs_convergence
  SOURCES convergence/mbs_order_test.cpp convergence/mbs_verlet_test.cpp
  LIBS mbs
  LABELS convergence)

# Prints the table of docs/coupling.md: what the interface Jacobian costs on chains.
add_executable(mbs_jacobian bench/mbs_jacobian.cpp)
target_link_libraries(mbs_jacobian PRIVATE tandem_options mbs tandem_side_process fmt::fmt)
