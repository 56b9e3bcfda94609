"""Counter for refused events, with the last reason in words."""


class Refusals:
    """Refused events, shared by all event handlers. A refusal never raises, so the show continues."""

    def __init__(self) -> None:
        self.count = 0
        """Number of refused events, such as calls of an unknown step."""
        self.last_reason = ""
        """Reason of the last refusal, for the operator."""

    def add(self, reason: str) -> None:
        """Record a refusal with its reason."""
        self.count += 1
        self.last_reason = reason
