"""Picture: the windows that a show is seen in, as a command line and a venue ask for them."""

from typing import TYPE_CHECKING

from live.app.output_places import places_of
from live.app.wish import Wish
from live.base.errors import PersonError
from live.base.stage_snapshot import Scene
from live.render.outputs.projection import Projection
from live.render.window.monitors import Monitor, UnknownMonitor
from live.render.window.window import NoWindow
from live.show.core import Show

if TYPE_CHECKING:
    from live.show.venue.venue import Venue


class Picture(Projection):
    """A projection that a command line opened."""

    @classmethod
    def opened(
        cls, wish: Wish, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, hidden: bool = False,
        venue: "Venue | None" = None,
    ) -> "Picture":  # fmt: skip
        """Open its windows; `hidden`: they are seen only when they are revealed. PersonError if there can be none."""
        places = places_of(wish, venue, monitor=monitor, fullscreen=fullscreen, hidden=hidden)
        try:
            return cls(scene, places)
        except (NoWindow, UnknownMonitor) as error:
            raise PersonError(str(error)) from None

    def rehearse(self, show: Show) -> None:
        """Draw a picture that nobody sees, so that the driver has compiled everything before it counts."""
        view = show.view()
        show.fill(view, 0.0)
        self.renderer.draw(view, self.pictures.next)
        self.window.ctx.finish()
