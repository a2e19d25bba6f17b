# Tests of the repository itself, its scripts and its generated pages, one executable a line.
tandem_test(architecture
  SOURCES architecture/architecture_test.cpp architecture/code_rules.cpp
    architecture/page_rules.cpp architecture/source_tree.cpp
  LIBS fmt::fmt LABELS architecture)
tandem_test(scenario_docs SOURCES golden/scenario_docs.cpp LABELS golden)
add_dependencies(scenario_docs tandem)
tandem_test(scripts SOURCES process/scripts.cpp LIBS nlohmann_json::nlohmann_json LABELS process)
