# Tests of protocol_wire, one executable a line.
tandem_test(wire_messages SOURCES unit/wire/chunks.cpp unit/wire/filter.cpp unit/wire/messages.cpp unit/wire/poll_budget.cpp unit/wire/process_names.cpp unit/wire/requests.cpp LIBS tandem_wire lcm::lcm ZLIB::ZLIB LABELS unit)
target_include_directories(wire_messages SYSTEM PRIVATE ${PROJECT_BINARY_DIR}/protocol/wire/generated)
tandem_test(wire_log SOURCES unit/wire/log.cpp LIBS tandem_wire lcm::lcm LABELS unit)
tandem_test(wire_bytes SOURCES golden/wire_bytes.cpp LIBS tandem_wire LABELS golden)
tandem_test(wire_journal SOURCES contract/wire_journal.cpp LIBS tandem_wire LABELS contract)
tandem_test(wire_exchange SOURCES process/wire_exchange.cpp LIBS tandem_wire lcm::lcm LABELS process)
tandem_test(wire_bodies SOURCES process/wire_bodies.cpp LIBS tandem_side_process LABELS process)
tandem_test(control_inbox SOURCES contract/control_inbox.cpp LIBS tandem_side_process LABELS contract)
tandem_test(wire_strangers SOURCES process/wire_strangers.cpp LIBS tandem_wire LABELS process)
tandem_test(wire_faults SOURCES process/wire_faults.cpp LIBS tandem_wire LABELS process)
tandem_test(wire_failures SOURCES process/wire_failures.cpp LIBS tandem_wire LABELS process)

# A process with a mock side, and the library that disturbs what it sends (LD_PRELOAD). The shim is
# built without the project's options: a sanitizer's runtime must not come in through it.
add_executable(wire_peer support/wire_peer.cpp)
target_link_libraries(wire_peer PRIVATE tandem_wire)
add_library(tandem_fault_shim SHARED support/fault_shim.cpp)
target_link_libraries(tandem_fault_shim PRIVATE ${CMAKE_DL_LIBS})
foreach(test wire_faults wire_failures)
  add_dependencies(${test} wire_peer tandem_fault_shim)
  target_compile_definitions(${test} PRIVATE TANDEM_FAULT_SHIM="$<TARGET_FILE:tandem_fault_shim>")
endforeach()
