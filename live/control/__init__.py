"""What comes in from people and machines: OSC, audio, keys; decoded within bounds, handed over as events."""
