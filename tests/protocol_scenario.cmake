# Tests of protocol_scenario, one executable a line.
tandem_test(test_scenario
  SOURCES unit/scenario/attachment.cpp unit/scenario/common_keys.cpp unit/scenario/defects.cpp unit/scenario/flexible_bodies.cpp unit/scenario/law.cpp unit/scenario/multibody_worlds.cpp
          unit/scenario/override.cpp unit/scenario/reference.cpp unit/scenario/resolved.cpp
  LIBS tandem_scenario nlohmann_json::nlohmann_json
  LABELS unit)
