"""Films of single dancers: a walk through the motion graph, a measure line, a sketch that is danced, a partner."""

import itertools
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import matplotlib
import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import Camera
from live.graph.clusters import join_summaries
from live.graph.motion_graph import MotionGraph
from live.motion.editing.foot_correction import BALLS
from tools.docs_films.film_file import FPS, SIZE, Picture
from tools.docs_films.floor_plan import EDGE, FAINT, GROUND, INK, Canvas, Colour, mixed
from tools.docs_films.group_films import load_own
from tools.docs_films.stage_play import (
    ROOT,
    WARM_UP_S,
    Projection,
    StageCamera,
    film_stage,
    load,
    play,
    seconds_of,
    with_camera,
)

Float64 = npt.NDArray[np.float64]

STEP_COLOURS: Final[tuple[Colour, ...]] = (
    (238, 122, 64), (92, 176, 226), (232, 196, 92), (124, 200, 140), (200, 140, 214),
)  # fmt: skip
FOOT_COLOURS: Final[tuple[Colour, Colour]] = ((255, 176, 92), (104, 188, 255))
"""Of the left and the right foot."""


# -- the motion graph --------------------------------------------------------------------------------------------------

RING: Final = (186.0, 182.0, 112.0)
"""Middle and radius of the graph [pixels]."""
GRAPH_WIDTH: Final = 384


class GraphLayout:
    """The steps of a library on a ring, each with its measure on the left and on the right foot."""

    def __init__(self, graph: MotionGraph) -> None:
        library = graph.library
        self.place = 2 * library.node_step + (library.node_side > 0)
        """Circle of each node, (N,): directions of a step share one."""
        self.names = library.steps
        self.arcs = [(arc.source, arc.target) for arc in join_summaries(graph, self.place, 2 * len(self.names))]

    def at(self, circle: int) -> Float64:
        """Return the middle of a circle [pixels]."""
        step, side = divmod(circle, 2)
        angle = 2.0 * math.pi * step / len(self.names) + (side - 0.5) * 0.62
        return np.array((RING[0] + RING[2] * math.sin(angle), RING[1] - RING[2] * math.cos(angle)))

    def arc(self, source: int, target: int) -> Float64:
        """Return the points of the arc from a circle to another, (n, 2): it bends to the middle of the ring."""
        a, b = self.at(source), self.at(target)
        bow = 0.5 * (a + b) * 0.62 + 0.38 * np.array(RING[:2])
        bow = bow + 0.1 * np.array((-(b - a)[1], (b - a)[0]))
        t = np.linspace(0.0, 1.0, 24)[:, None]
        return np.asarray((1 - t) ** 2 * a + 2 * t * (1 - t) * bow + t**2 * b)

    def name_at(self, step: int) -> Float64:
        """Return where a step's name stands."""
        angle = 2.0 * math.pi * step / len(self.names)
        return np.array((RING[0] + (RING[2] + 44) * math.sin(angle), RING[1] - (RING[2] + 34) * math.cos(angle)))


def draw_motion_graph() -> list[Picture]:
    """A dancer's walk through the graph of measures, beside the dancer."""
    loaded = load_own("motion-graph")
    layout = GraphLayout(loaded.graph)
    begin, seconds = seconds_of(loaded, 2.0), seconds_of(loaded, 8.0)
    pictures: list[Picture] = []
    walked: list[int] = []
    with StageCamera(loaded, (SIZE[0] - GRAPH_WIDTH, SIZE[1])) as camera:
        for show, view in play(loaded, begin, seconds, lead_in=WARM_UP_S):
            here = int(layout.place[show.dancers.node[0]])
            step = int(loaded.graph.library.node_step[show.dancers.node[0]])
            if not walked or walked[-1] != here:
                walked.append(here)
            then = int(layout.place[show.dancers.coming.node[0]]) if show.dancers.decided else None
            canvas = Canvas()
            _draw_graph(canvas, layout, walked, then, step, view.phase / view.beats_per_measure)
            canvas.paste(camera.draw(view), (GRAPH_WIDTH, 0))
            pictures.append(canvas.picture())
    return pictures[-round(seconds * FPS) :]


def _draw_graph(
    canvas: Canvas, layout: GraphLayout, walked: list[int], then: int | None, step: int, phase: float
) -> None:
    for source, target in layout.arcs:
        canvas.line(layout.arc(source, target), mixed(EDGE, GROUND, 0.35), 1.0)
    for age, (source, target) in enumerate(zip(walked[-2::-1], walked[:0:-1], strict=True)):
        if age < 4:
            canvas.line(layout.arc(source, target), mixed(INK, GROUND, 0.35 + 0.15 * age), 2.4 - 0.4 * age)
    here = walked[-1]
    if then is not None:
        way = layout.arc(here, then)
        canvas.line(way, STEP_COLOURS[then // 2], 2.6)
    for circle in range(2 * len(layout.names)):
        colour = STEP_COLOURS[circle // 2]
        lit = circle == here
        canvas.disc(layout.at(circle), 17.0 if lit else 12.0, colour if lit else mixed(colour, GROUND, 0.62), colour)
    if then is not None:
        canvas.disc(layout.arc(here, then)[min(23, round(23 * phase**2))], 5.5, INK)
    for number, name in enumerate(layout.names):
        x, y = layout.name_at(number)
        canvas.text((float(x), float(y)), name, INK if number == step else FAINT, 15.0, "mm")


# -- the measure line --------------------------------------------------------------------------------------------------

STRIP: Final = 104
"""Height of the strip of measures below the dancer [pixels]."""
PRESENT: Final = 250.0
BEAT_PIXELS: Final = 52.0
SHOWN_BEATS: Final = 9.0
"""So many beats before the present are kept."""


@dataclass(frozen=True, slots=True, eq=False)
class DancedMoment:
    """One picture of the dancer with what is known at that time."""

    beat: float
    measures: dict[int, str]
    """Step of each measure that is danced or decided, by its number."""
    contact: tuple[bool, bool]
    feet: Float64
    """Balls of both feet [m], (2, 3)."""


def draw_measure_line() -> list[Picture]:
    """A dancer above, the measures below: when the next is chosen, the blend before the line, feet that stand."""
    loaded = load_own("measure-line")
    library, blend = loaded.graph.library, loaded.patch.locomotion.transition_beats
    begin, seconds = seconds_of(loaded, 6.0), seconds_of(loaded, 4.0)
    size = (SIZE[0], SIZE[1] - STRIP)
    eye = Projection(loaded, size)
    measures: dict[int, str] = {}
    moments: list[DancedMoment] = []
    pictures: list[Picture] = []
    with StageCamera(loaded, size) as camera:
        for show, view in play(loaded, begin, seconds, lead_in=SHOWN_BEATS * 60.0 / loaded.patch.clock.bpm):
            measures[view.measure] = library.steps[library.node_step[show.dancers.node[0]]]
            if show.dancers.decided:
                measures[view.measure + 1] = library.steps[library.node_step[show.dancers.coming.node[0]]]
            left, right = show.dancers.contact(show.span.fraction(view.beat))[0].tolist()
            feet = view.joint_position[0, BALLS].astype(np.float64)
            moments.append(DancedMoment(view.beat, dict(measures), (left, right), feet))
            if view.time < begin - WARM_UP_S:
                continue
            canvas = Canvas()
            canvas.paste(camera.draw(view), (0, 0))
            for foot, colour in enumerate(FOOT_COLOURS):
                if moments[-1].contact[foot]:
                    canvas.ring(eye.circle(feet[foot] * (1.0, 0.0, 1.0), 0.17), colour)
            _draw_strip(canvas, moments, blend)
            pictures.append(canvas.picture())
    return pictures[-round(seconds * FPS) :]


def _draw_strip(canvas: Canvas, moments: list[DancedMoment], blend: float) -> None:
    now, known = moments[-1].beat, moments[-1].measures
    top, bottom = SIZE[1] - STRIP + 14.0, SIZE[1] - 44.0

    def across(beat: float) -> float:
        return PRESENT + (beat - now) * BEAT_PIXELS

    canvas.box((0.0, float(SIZE[1] - STRIP), float(SIZE[0]), float(SIZE[1])), GROUND)
    for number in sorted(known):
        left, right = across(4.0 * number), across(4.0 * number + 4.0)
        if right < -10 or left > SIZE[0]:
            continue
        colour = _step_colour(known[number])
        canvas.box((left + 1.5, top, right - 1.5, bottom), mixed(colour, GROUND, 0.45 if left <= PRESENT else 0.65))
        if number - 1 in known:  # the next step comes in before the line
            wedge = mixed(colour, GROUND, 0.25)
            canvas.polygon(((left - blend * BEAT_PIXELS, bottom), (left + 1, top), (left + 1, bottom)), wedge)
        canvas.text(
            (max(left + 10, 8.0) if left < PRESENT else left + 10, (top + bottom) / 2), known[number], INK, 15.0
        )
        for line in (left, right):
            canvas.line(((line, top - 8), (line, SIZE[1] - 8.0)), FAINT, 2.5)
    for foot, colour in enumerate(FOOT_COLOURS):
        y = SIZE[1] - 31.0 + 13.0 * foot
        for before, moment in itertools.pairwise(moments):
            if moment.contact[foot]:
                canvas.box((across(before.beat), y - 4, across(moment.beat) + 0.4, y + 4), mixed(colour, GROUND, 0.15))
    canvas.line(((PRESENT, top - 12), (PRESENT, SIZE[1] - 6.0)), INK, 2.0)


def _step_colour(name: str) -> Colour:
    order = ("side step", "kick", "grapevine", "reach", "turn")
    return STEP_COLOURS[order.index(name)] if name in order else FAINT


# -- a sketch ----------------------------------------------------------------------------------------------------------

SKETCH: Final = ROOT / "patches" / "steps" / "kick.toml"
KEYS: Final = ("1", "1&", "2", "2&")
TEXT_WIDTH: Final = 352
HOLD_S: Final = 0.9
LINE: Final = 13.7
MONO: Final = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSansMono.ttf"


def draw_sketch_to_step() -> list[Picture]:
    """The text of a step: its key poses one by one, then the step is danced in time."""
    loaded = load_own("sketch-to-step")
    beat_s = 60.0 / loaded.patch.clock.bpm
    begin = seconds_of(loaded, 2.0)
    lines = [line.partition("#")[0].rstrip() for line in SKETCH.read_text(encoding="utf-8").splitlines()]
    lines = [line for line in lines[next(n for n, line in enumerate(lines) if line.startswith("[")) :] if line]
    pictures: list[Picture] = []
    with StageCamera(loaded, (SIZE[0] - TEXT_WIDTH, SIZE[1])) as camera:
        danced = []
        for _, view in play(loaded, begin, seconds_of(loaded, 2.0), lead_in=WARM_UP_S):
            danced.append((view.phase, camera.draw(view)))
    danced = danced[-round(seconds_of(loaded, 2.0) * FPS) :]
    for number, key in enumerate(KEYS):
        still = danced[round((4.0 + 0.5 * number) * beat_s * FPS)][1]
        pictures += [_sketch_picture(lines, key, still)] * round(HOLD_S * FPS)
    for phase, picture in danced:
        key = KEYS[int(2.0 * phase + 1e-6) % 4]
        pictures.append(_sketch_picture(lines, key, picture))
    return pictures


def _sketch_picture(lines: list[str], key: str, dancer: Picture) -> Picture:
    canvas = Canvas()
    canvas.paste(dancer, (TEXT_WIDTH, 0))
    top = (SIZE[1] - LINE * len(lines)) / 2.0
    for number, line in enumerate(lines):
        y = top + (number + 0.5) * LINE
        lit = line.startswith(f'"{key}"')
        if lit:
            canvas.box(
                (6.0, y - LINE / 2, TEXT_WIDTH - 6.0, y + LINE / 2), mixed(STEP_COLOURS[0], GROUND, 0.62), None, 2
            )
        colour = FAINT if line.startswith("[") else INK if lit else mixed(INK, GROUND, 0.35)
        canvas.text((12.0, y), line, colour, 10.6, font=str(MONO))
    return canvas.picture()


# -- a partner ---------------------------------------------------------------------------------------------------------


def draw_partner() -> list[Picture]:
    """A leader, and the follower whose motion is made for her while she dances."""
    loaded = with_camera(load("patches/partner.toml"), Camera((-0.75, 1.5, 6.4), (-0.75, 0.84, 0.8), 25.0))
    groups = tuple(group for group in loaded.patch.group if group.name != "others")
    loaded = replace(loaded, patch=loaded.patch.model_copy(update={"group": groups}))
    return film_stage(loaded, seconds_of(loaded, 4.0), seconds_of(loaded, 4.0))
