"""Where the windows of a show open: what the command line and the venue say, against the monitors there are."""

from dataclasses import replace

from live.app.wish import Wish
from live.base.errors import PersonError, named
from live.render.outputs.output import Output
from live.render.outputs.output_pass import read_mask
from live.render.outputs.projection import Places
from live.render.window.monitor_places import find_place
from live.render.window.monitors import Monitor, UnknownMonitor
from live.show.venue.venue import Venue, venue_path


def outputs_of(venue: Venue | None, name: str | None) -> tuple[Output, ...]:
    """The outputs of a venue, one that shows all of the picture if it says nothing; `name` is the venue's."""
    if venue is None or name is None or not venue.output:
        return (Output(),)
    folder = venue_path(name).parent
    return tuple(one.output(folder) for one in venue.output)


def places_of(wish: Wish, venue: Venue | None, *, monitor: Monitor | None, fullscreen: bool, hidden: bool) -> Places:
    """All windows and where they open; PersonError for monitors that are not there. `--monitor` wins over what a
    venue with one output says."""
    outputs = outputs_of(venue, wish.venue)
    if hidden:  # who goes on with a show does so without a mask that was lost
        outputs = tuple(one if _mask_is_there(one) else replace(one, mask=None) for one in outputs)
    if len(outputs) == 1 and monitor is not None:
        outputs = (replace(outputs[0], monitor=None),)
    for number, output in enumerate(outputs):
        if output.monitor is not None:
            found(output.monitor, f"venue {wish.venue}: output.{number + 1}.monitor")
    of_venue = None if venue is None else venue.operator
    asked = wish.operator or of_venue
    where = "--operator" if wish.operator else f"venue {wish.venue}: operator"
    operator = None if asked is None else found(asked, where)
    return Places(outputs, monitor, operator, wish.size, fullscreen, hidden)


def _mask_is_there(output: Output) -> bool:
    try:
        return output.mask is None or read_mask(output) is not None
    except PersonError:
        return False


def found(text: str, where: str) -> Monitor:
    """The monitor that is meant; PersonError, beginning with `where` that was said, with those there are."""
    with named(where):
        try:
            return find_place(text)
        except UnknownMonitor as error:
            raise PersonError(str(error), "plug it in, or name another one") from None
