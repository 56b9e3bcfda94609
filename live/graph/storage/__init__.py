"""How a library keeps its clips: rotations of one sign, mean poses."""
