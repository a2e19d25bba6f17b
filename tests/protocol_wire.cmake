# Tests of protocol_wire, one executable a line.
tandem_test(wire_exchange SOURCES process/wire_exchange.cpp LIBS tandem_wire LABELS process)
