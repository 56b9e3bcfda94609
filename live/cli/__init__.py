"""The command line: the only place that opens windows and devices and wires the layers together."""
