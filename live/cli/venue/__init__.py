"""Commands for the venue and its machine: devices, doctor, calibration. They may import every layer."""
