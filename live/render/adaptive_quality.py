"""Quality levels of the picture, and the controller that changes them with frame times.

One tier is for software rendering, one for graphics cards and offline films. Quality goes down at once, because a late
frame is visible, and up slowly, because a change that is soon reverted is visible too. Only the drawing changes, never
the dance.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import moderngl

from live.render.body.body_mesh import CLOSE, DISTANT, FINE, LIGHT
from live.render.headless import is_software

_MEDIUM_ABOVE: Final = 120
"""With more dancers than this, a graphics card also draws the light body, and the distant one far away."""


@dataclass(frozen=True, slots=True)
class Quality:
    """Quality settings that the passes read before they allocate and draw."""

    samples: int
    """Multisampling of the picture. 0: deferred shading with edge smoothing, in 8 bits; more: forward shading in half
    floats, with bloom."""
    near_level: int
    """Body of the nearest dancers."""
    near_count: int
    """Maximum number of dancers with the near body; the others get `far_level`."""
    far_level: int
    floor_map: int
    """Texels along the longer side of the floor's map of shadows and elements (shadows are cast at twice that)."""
    mirror_divisor: int
    """The dancers' mirror images in the floor are drawn at 1/n of the picture's size."""
    left_out: tuple[str, ...] = ()
    """Passes that are never drawn at this quality."""
    scale: float = 1.0
    """The scene is drawn at this share of the picture's width and height, and stretched."""
    far_from: float = 12.0
    """Dancers nearer to the camera than this [m], seen through the usual lens, never get the far body."""
    points: int = 3000
    """Maximum number of points of a dancer drawn as particles."""
    ribbon_pieces: int = 96
    """Drawn pieces of each ribbon; fewer make it shorter."""
    ghost_level: int = LIGHT
    """Body of the ghosts of trails."""
    close_level: int = FINE
    """Body for close-ups."""
    close_count: int = 0
    """Maximum number of dancers with that body."""
    close_within: float = 4.5
    """Dancers farther from the camera than this [m] never get it."""

    def level_of(self, where: str) -> int:
        """Return the body of the dancers that are `close`, `near` or `far`."""
        return {"close": self.close_level, "near": self.near_level, "far": self.far_level}[where]


SOFTWARE: Final = Quality(0, LIGHT, 12, DISTANT, 256, 3, ("bloom", "focus", "blur"), close_level=CLOSE, close_count=6)
"""Without a graphics card: 50 dancers at 1280x720 in real time on two cores."""
HARDWARE: Final = Quality(4, CLOSE, 120, LIGHT, 768, 2, close_level=FINE, close_count=24, close_within=6.0)
"""For a graphics card, or for offline films."""


def choose_quality(ctx: moderngl.Context, dancer_count: int) -> Quality:
    """Return the tier for this driver, its multisampling limited to the driver's maximum."""
    quality = SOFTWARE if is_software(ctx) else HARDWARE
    if quality is HARDWARE and dancer_count > _MEDIUM_ABOVE:
        quality = replace(quality, near_level=LIGHT, near_count=400, far_level=DISTANT, close_count=80)
    return replace(quality, samples=min(quality.samples, int(ctx.max_samples)))


_CLOSE_BODIES_WITHIN: Final = 12.0
"""Beyond this [m], for a picture of 720 rows, triangles of the close body are smaller than pixels. Nobody sees
them, but software shades a block of pixels for each."""
_FILM_FLOOR_MAP: Final = 512
"""Shadows are soft: a finer map shows the same, and its blur costs as the cube of its size."""


def film_quality(ctx: moderngl.Context, height: int) -> Quality:
    """Return the best tier, for a picture of this height [pixels], with software rendering in what nobody sees less."""
    if not is_software(ctx):
        return HARDWARE
    far_from = _CLOSE_BODIES_WITHIN * height / 720.0
    return replace(HARDWARE, near_count=0, far_from=far_from, floor_map=_FILM_FLOOR_MAP)


HALF_LIFE_S: Final = 1.0
"""After so many seconds a late frame counts half. A step resets the count."""
LATE_SHARE_DOWN: Final = 0.06
"""A larger share of late frames, weighted by time, takes the next step down."""
SETTLE_S: Final = 1.0
"""Seconds after a step down before the next one, so that the effect of the first can be measured."""
WARM_UP_S: Final = 2.0
"""Late frames in the first seconds of a show are ignored, because drivers still compile."""
LATE_SHARE_UP: Final = 0.005
"""A smaller share of late frames than this for `PATIENCE_S`, with a load below `MAX_LOAD_UP`, takes a step up."""
PATIENCE_S: Final = 15.0
MAX_LOAD_UP: Final = 0.75
"""Quality goes up only while frames need less than this share of their time."""
MAX_PATIENCE_S: Final = 300.0
"""Maximum patience [s]; it doubles with every step up that had to be reverted."""


@dataclass(frozen=True, slots=True)
class QualityStep:
    """One quality level."""

    name: str
    """What is left out from this level on, in words."""
    quality: Quality
    kind: str = ""
    """The pass that it reduces, or `styles`; empty: it affects every picture. A step that would change nothing now is
    skipped."""


RESOLUTION_STEPS: Final = (("3/4 of the size", 0.75), ("3/5 of the size", 0.6), ("half the size", 0.5))
"""The last steps: name, and the share of the picture's width and height that they draw."""


def quality_steps(best: Quality) -> tuple[QualityStep, ...]:
    """Return the steps from `best` down, each with one more reduction; the resolution comes last."""
    changes: list[tuple[str, str, dict[str, object]]] = []
    left_out = best.left_out
    if best.samples > 2:
        changes.append(("half the samples", "", {"samples": 2}))
    for name in ("blur", "focus", "trails", "bloom", "mirror"):
        if name not in left_out:
            left_out = (*left_out, name)
            changes.append((f"no {name}", name, {"left_out": left_out}))
    fewer = {"points": best.points // 2, "ribbon_pieces": best.ribbon_pieces // 2, "ghost_level": DISTANT}
    changes.insert(-1, ("half the particles and ribbons", "styles", dict(fewer)))
    changes.append(("a coarse floor", "", {"floor_map": max(best.floor_map // 2, 128)}))
    changes.append(("lighter bodies", "", _lighter(best)))
    for name, scale in RESOLUTION_STEPS:
        change: dict[str, object] = {"scale": scale * best.scale}
        if (
            best.near_level == LIGHT
        ):  # pixels are wider then: the body's outline shifts by as many of them as it did farther away
            change["far_from"] = min(8.0, best.far_from * scale)
        changes.append((name, "", change))
    steps, quality = [QualityStep("all", best)], best
    for name, kind, change in changes:
        quality = replace(quality, **change)  # type: ignore[arg-type]
        steps.append(QualityStep(name, quality, kind))
    return tuple(steps)


def _lighter(best: Quality) -> dict[str, object]:
    if best.near_level == LIGHT:
        return {
            "near_count": best.near_count // 4, "far_level": DISTANT, "far_from": min(8.0, best.far_from),
            "close_count": best.close_count // 3,
        }  # fmt: skip
    return {"near_count": 8, "far_level": LIGHT, "far_from": 5.0}  # within 5 m no body changes


class QualityController:
    """Controller that chooses the quality step from the timing of each frame. Thread: the show's."""

    def __init__(self, steps: int, has_effect: Callable[[int], bool] = lambda step: True) -> None:
        """`steps`: their number; 0 is the best. `helps(step)`: whether that step would reduce the current picture."""
        self._steps, self._has_effect = steps, has_effect
        self.step = 0
        """The current step."""
        self.changes = 0
        """How often the step has changed."""
        self.held: int | None = None
        """The step held by the operator, or None."""
        self._share = self._calm = 0.0
        self._since_step = SETTLE_S - WARM_UP_S
        self._patience = PATIENCE_S
        self._raised = False

    def hold(self, step: int | None) -> None:
        """Hold this step (limited to the last one) until further notice; None: automatic again."""
        self.held = None if step is None else min(max(step, 0), self._steps - 1)
        if self.held is not None and self.held != self.step:
            self._set_step(self.held, raised=False)
        self._since_step = self._calm = self._share = 0.0

    def update(self, late: bool, seconds: float, load: float, overload: float = 0.0) -> int:
        """Return the step for the next frame, after one that came `seconds` after the last one.

        `load`: the share of the frame period that was needed, waiting excluded. `overload`: overload of the whole
        machine, 0 to 1. The higher it is, the fewer late frames cause a step down; there is no step up while it is
        above 0.
        """
        if self.held is not None:
            return self.step
        self._since_step += seconds
        kept = 0.5 ** (max(seconds, 0.0) / HALF_LIFE_S)
        self._share = kept * self._share + (1.0 - kept) * (late and (self.changes > 0 or self._since_step > SETTLE_S))
        if self._share > max(LATE_SHARE_DOWN * (1.0 - overload), LATE_SHARE_UP):
            self._calm = 0.0
            if self._since_step > SETTLE_S and self.step < self._steps - 1:
                if self._raised and self._since_step < 4.0 * PATIENCE_S:  # it was too early to go up
                    self._patience = min(2.0 * self._patience, MAX_PATIENCE_S)
                self._set_step(self._next_down(), raised=False)
            return self.step
        self._calm = (
            self._calm + seconds if self._share < LATE_SHARE_UP and load < MAX_LOAD_UP and not overload else 0.0
        )
        if self._calm >= self._patience and self.step > 0:
            self._set_step(self._next_up(), raised=True)
        return self.step

    def _next_down(self) -> int:
        """Return the next step down that reduces this picture, or the last one."""
        return next((step for step in range(self.step + 1, self._steps) if self._has_effect(step)), self._steps - 1)

    def _next_up(self) -> int:
        """Return the step above the lowest one that has an effect now."""
        felt = self.step
        while felt > 1 and not self._has_effect(felt):
            felt -= 1
        return felt - 1

    def _set_step(self, step: int, *, raised: bool) -> None:
        self.step, self._raised = step, raised
        self._since_step = self._calm = self._share = 0.0
        self.changes += 1
