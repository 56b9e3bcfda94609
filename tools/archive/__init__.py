"""Archive for a machine without Python and network: program, packages, interpreter, libraries, launcher."""
