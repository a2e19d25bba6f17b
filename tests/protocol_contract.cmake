# Tests of protocol_contract, one executable a line.
tandem_test(contract_files SOURCES unit/whole_file.cpp LIBS tandem_contract LABELS unit)
