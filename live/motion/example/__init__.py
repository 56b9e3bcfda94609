"""Motion by example: a leader's motion is read as a row of recorded units, and their followers answer (H001-H027)."""
