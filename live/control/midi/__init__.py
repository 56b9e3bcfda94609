"""MIDI ports, messages, maps and learning. May import the same layers as `control`."""
