"""Detail and missing joints of a sketched motion, out of motion capture (Pullen and Bregler 2002; P001-P024)."""
