# Tests of protocol_schemes, one executable a line.
