# Tests of protocol_scenario, one executable a line.
