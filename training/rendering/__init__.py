"""From notes to sound: FluidSynth's library, then rooms, crowds, media and levels in numpy."""
