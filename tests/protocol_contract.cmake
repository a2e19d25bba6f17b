# Tests of protocol_contract, one executable a line.
