# Tests of mbs, one executable a line.
