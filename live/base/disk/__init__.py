"""Files that only save time: compiled kernels, and arrays that take long to compute."""
