# Tests of protocol_contract, one executable a line.
tandem_test(contract_files SOURCES unit/contract/whole_file.cpp LIBS tandem_contract LABELS unit)
