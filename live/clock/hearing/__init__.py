"""Sound in, beat and downbeat activations out: what one hears in each frame of 11.6 ms, before any rhythm is made of it."""
