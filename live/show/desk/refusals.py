"""Refusals: what was asked of a show that it does not have; counted, and the last one kept in words."""


class Refusals:
    """Shared by all who act on events: nothing raises, the show goes on."""

    def __init__(self) -> None:
        self.count = 0
        """Events that asked for something the show does not have (a step that is not there)."""
        self.words = ""
        """The last such event in words, for the operator."""

    def add(self, words: str) -> None:
        """Something was refused, for this reason."""
        self.count += 1
        self.words = words
