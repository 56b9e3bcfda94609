"""Score interpreter: sections, sequences, improvisation and reactions to music. It may import what `show` may."""
