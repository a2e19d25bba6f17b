// What the test of number texts must pass over.
#include <string>

std::string planted_whole_text(long long value) { return std::to_string(value); }
