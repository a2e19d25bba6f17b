# Tests of protocol_schemes, one executable a line.
tandem_test(test_schemes
  SOURCES unit/schemes_test.cpp
  LIBS tandem_driver tandem_schemes
  LABELS unit)
