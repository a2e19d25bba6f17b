# Tests of fem, one executable a line.
