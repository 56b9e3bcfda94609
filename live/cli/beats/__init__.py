"""Commands for beats: beat tracking of sound, and checks of a MIDI clock. They may import every layer."""
