# Tests of coupled, one executable a line.
