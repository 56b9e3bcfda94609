"""MIDI ports, messages, maps and learning. It may import what `control` may."""
