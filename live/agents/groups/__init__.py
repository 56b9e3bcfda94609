"""Groups: who is meant, by number, attribute, name or place on the stage; divided, mirrored, one after the other."""
