"""Sound in, beat and downbeat activations out: what is heard in each frame, before any rhythm is made of it."""
