"""Acting: an event that cannot act, for an error of this program, is refused by everybody in the same way.

The engine that dances, the one that goes on after it, a machine that stands by and a replay all come to the same state:
what the event had done before the error stays done, the same everywhere, and the show goes on.
"""

from live.control.events.event import ControlEvent
from live.show.core import Show


def act(show: Show, event: ControlEvent) -> bool | None:
    """Let an event act, from the next tick on; False if it asked for what is not there, None if it failed."""
    try:
        return show.apply(event)
    except Exception as error:  # whatever it is: one event less, and not a show less
        show.refusals.add(f"{type(event).__name__} failed: {type(error).__name__}: {error}")
        return None
