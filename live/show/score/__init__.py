"""The score: sections, sequences, improvisation, reactions to music. It may import what `show` may."""
