# Tests of fem, one executable a line.
tandem_test(fem_unit
  SOURCES unit/fem_interface_jacobian.cpp unit/fem_momentum.cpp
  LIBS fem LABELS unit)
tandem_test(fem_contract SOURCES contract/fem_contract.cpp LIBS fem LABELS contract)
