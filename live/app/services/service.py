"""A service of a show: what it has to offer, and what it may offer besides."""

from typing import Any, Protocol


class Service(Protocol):
    """Service of a show with its own device or network port. Thread: the show's.

    It may also have the following methods, which are called as their names say: `before_frame()`, `publish(changes)`
    with changed values, `handle(event)` with each applied event, `update_patch(patch)`, `refused()` for the number of
    refused inputs by reason, and `refusal()` for the last one in words.
    """

    def start(self) -> None:
        """Open device or port; raise PersonError if that fails."""
        ...

    def stop(self) -> None:
        """Close device or port; may be called without `start`."""
        ...

    def frame(self) -> None:
        """Update the service after each frame."""
        ...

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        ...
