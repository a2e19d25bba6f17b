// What the test of number texts must find.
#include <string>

std::string planted_real_text(double value) { return std::to_string(value); }
