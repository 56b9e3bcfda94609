"""Commands about the venue and its machine: devices, doctor, calibration. It may import every layer."""
