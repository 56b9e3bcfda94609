"""Audio devices: input, output and latency measurement. It may import what `control` may."""
