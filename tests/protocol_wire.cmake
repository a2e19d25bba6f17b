# Tests of protocol_wire, one executable a line.
