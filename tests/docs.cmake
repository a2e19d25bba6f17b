# Tests of the repository itself, its scripts and its generated pages, one executable a line.
tandem_test(architecture
  SOURCES architecture/architecture_test.cpp architecture/code_rules.cpp
    architecture/page_rules.cpp architecture/source_tree.cpp
  LIBS fmt::fmt LABELS architecture)
tandem_test(scenario_docs SOURCES golden/scenario_docs.cpp LABELS golden)
add_dependencies(scenario_docs tandem)
# Looks at what the libraries were compiled to.
add_library(planted_real_text OBJECT architecture/planted_real_text.cpp)
add_library(planted_whole_text OBJECT architecture/planted_whole_text.cpp)
tandem_test(number_texts SOURCES architecture/number_texts.cpp architecture/source_tree.cpp LIBS fmt::fmt LABELS architecture)
set(libraries tandem_contract tandem_scenario tandem_schemes tandem_wire tandem_driver
  tandem_side_process mbs fem orchestrator)
list(TRANSFORM libraries REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE library_files)
list(JOIN library_files "|" library_files)
target_compile_definitions(number_texts PRIVATE TANDEM_NM="${CMAKE_NM}"
  TANDEM_LIBRARIES="${library_files}"
  TANDEM_PLANTED_REAL="$<TARGET_OBJECTS:planted_real_text>"
  TANDEM_PLANTED_WHOLE="$<TARGET_OBJECTS:planted_whole_text>")
add_dependencies(number_texts ${libraries} planted_real_text planted_whole_text)
tandem_test(scripts SOURCES process/scripts.cpp LIBS nlohmann_json::nlohmann_json LABELS process)
