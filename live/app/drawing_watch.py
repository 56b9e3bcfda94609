"""What is drawn of a live show, watched: where its time goes, and how much quality it can afford or is told to keep."""

from live.app.session import Session
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.control.events.event import ControlEvent
from live.control.events.events import HoldQuality, ResetBreaker
from live.render.frame_budget import Affordance
from live.render.renderer import Renderer
from live.show.patch.patch import Patch


def watch_passes(session: Session, renderer: Renderer) -> None:
    """Let a person put passes back into the picture that were left out because they could not be drawn."""

    def hear(event: ControlEvent) -> None:
        if isinstance(event, ResetBreaker):
            renderer.reset_pass(event.name)

    session.engine.outward.append(hear)


class DrawingWatch(Affordance):
    """Belongs to one picture of a session; called around every frame."""

    def __init__(self, session: Session, renderer: Renderer) -> None:
        super().__init__(renderer, session.clock.now)
        self.overload = lambda: session.overload
        self.ladder.hold(session.wish.quality)
        session.engine.mark = self.times.mark
        session.engine.outward.append(self.hear)
        watch_passes(session, renderer)
        session.engine.patched.append(self.take_patch)
        session.status.more["quality"] = self.facts
        session.status.more["frame_parts"] = self.times.facts
        session.status.notes.append(self._words)
        self._problem = ""
        session.status.notes.append(lambda: "; ".join(filter(None, (self._problem, *self._renderer.problems))))

    def hear(self, event: ControlEvent) -> None:
        """An event that the show has heard: a step of quality is held so."""
        if isinstance(event, HoldQuality):
            self.ladder.hold(None if event.step < 0.0 else round(event.step))

    def take_patch(self, patch: Patch) -> None:
        """Another patch is in force: its own passes may have other texts."""
        try:
            self._renderer.take_own(patch.picture.own_passes)
            self._problem = ""
        except PersonError as error:
            self._problem = f"{error}; the last good one goes on"

    def graph(self, view: StageView) -> None:
        """Let the overlay show the last frames."""
        graph = self._renderer.graph
        graph.period = self.period * 1e3 if view.overlay else 0.0
        if view.overlay:
            graph.count = self.times.recent(graph.times)

    def _words(self) -> str:
        blamed = [f"{name} {count}" for name, count in self.times.blamed.items() if count]
        return "   ".join(filter(None, (self.words(), f"late by {', '.join(blamed)}" if blamed else "")))
