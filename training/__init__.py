"""Training music for the beat network: composed from rules, sounded by General MIDI fonts, annotated exactly."""
