# Tests of mbs, one executable a line.
tandem_test(test_mbs
  SOURCES unit/mbs_drift_test.cpp unit/mbs_energy_test.cpp unit/mbs_keys_test.cpp unit/mbs_motion_test.cpp
    unit/mbs_motors_test.cpp unit/mbs_params_test.cpp unit/mbs_softness_test.cpp unit/mbs_springs_test.cpp
    unit/mbs_state_test.cpp unit/mbs_stops_test.cpp unit/mbs_wrench_rule_test.cpp
  LIBS mbs
  LABELS unit)
tandem_test(test_mbs_contract
  SOURCES contract/mbs_jacobian_test.cpp contract/mbs_rollback_test.cpp
  LIBS mbs
  LABELS contract)
tandem_test(test_mbs_convergence
  SOURCES convergence/mbs_order_test.cpp convergence/mbs_verlet_test.cpp
  LIBS mbs
  LABELS convergence)
