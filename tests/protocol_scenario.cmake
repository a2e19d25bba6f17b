# Tests of protocol_scenario, one executable a line.
tandem_test(test_scenario
  SOURCES unit/scenario_attachment.cpp unit/scenario_common_keys.cpp unit/scenario_defects.cpp unit/scenario_law.cpp
          unit/scenario_override.cpp unit/scenario_reference.cpp unit/scenario_resolved.cpp
  LIBS tandem_scenario nlohmann_json::nlohmann_json
  LABELS unit)
