"""What every layer may use: vector and quaternion kernels, hand-over between threads, the drawing snapshot."""
