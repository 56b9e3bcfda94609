"""The bodies that dancers can have, by name: one skeleton, other flesh on it."""

from typing import Final

USUAL: Final = "dancer"
"""The body of everybody of whom nothing else is said."""
BODIES: Final = (USUAL, "slim", "strong", "round", "child")
"""All bodies; a dancer's joints are the same in each, so her feet stand and her hands meet as they should."""
