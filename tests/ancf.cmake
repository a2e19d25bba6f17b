# Tests of the beams and tracks of the flexible side, one executable a line.
tandem_test(ancf_unit SOURCES unit/ancf_connections.cpp unit/ancf_contact.cpp unit/ancf_element.cpp LIBS fem LABELS unit)
tandem_test(ancf_reference SOURCES reference/ancf_dynamics.cpp reference/ancf_statics.cpp LIBS fem LABELS reference)
