"""The part of a live show that tells musicians and other programs over OSC what happens in it."""

from typing import TYPE_CHECKING, Any

from live.app.option_values import parse_endpoint
from live.base.errors import PersonError
from live.clock.time_source import Clock
from live.control.helper_process import Helper
from live.control.osc.osc_output import Targets
from live.show.core import Show
from live.show.engine import Engine
from live.show.outgoing import Outgoing
from live.show.venue.venue import Venue

if TYPE_CHECKING:
    from live.app.wish import Wish


class OscOutPart:
    """Between the show and the process that sends. Thread: the one that runs the show."""

    def __init__(self, engine: Engine, outgoing: Outgoing, targets: tuple[tuple[str, int], ...], clock: Clock) -> None:
        self._engine, self._outgoing, self._targets = engine, outgoing, targets
        self._helper = Helper("live.control.osc.osc_output", clock, {"targets": targets}, outgoing.anew)

    def start(self) -> None:
        """Begin to send; PersonError for a host that nobody knows."""
        try:
            Targets(self._targets).close()
        except OSError as error:
            shown = ", ".join(f"{host}:{port}" for host, port in self._targets)
            raise PersonError(f"--osc-out {shown}: {error.strerror or error}", "name hosts by their numbers") from None
        self._helper.start()

    def stop(self) -> None:
        """Send nothing any more."""
        self._helper.stop()

    def frame(self) -> None:
        """After each frame: what there is to tell."""
        self._helper.frame()
        for told in self._outgoing.frame(self._engine.view):
            self._helper.send(told)

    def status(self) -> dict[str, Any]:
        """For the status line."""
        to = [f"{host}:{port}" for host, port in self._targets]
        return {"to": to, **self._helper.facts(), "too_many": self._outgoing.left_out}


def make_osc_out(wish: "Wish", show: Show, venue: Venue | None, clock: Clock, engine: Engine) -> OscOutPart | None:
    """What `--osc-out`, the venue or the patch asks for, to be started; None if nobody is to be told."""
    section = show.patch.osc
    named = section.out if venue is None or not venue.osc.out else venue.osc.out
    targets = wish.osc_out or tuple(parse_endpoint(each, "[osc] out") for each in named)
    if not targets:
        return None
    outgoing = Outgoing(show, positions=section.positions_per_second, feet=section.feet)
    return OscOutPart(engine, outgoing, targets, clock)
