"""Rows of the show bench: a score of 5,000 measures with 20,000 entries, its loading and what it costs a frame."""

import tempfile
import time
from pathlib import Path

import numpy as np

from live.cli.bench import Row
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.show import Show

MEASURES = 5000
LOAD_BAR_S = 1.5
FRAME_BAR_MS = 0.2
FRAMES = 128
"""Frames of a measure: four beats at 112 bpm and 60 frames/s."""
RUN = 400
"""Measures that are gone through."""


def long_score(folder: Path) -> Path:
    """A patch with a long score, written into `folder`: sections of a hundred measures, four entries in every one."""
    parts = [
        DEFAULT_PATCH.read_text(encoding="utf-8").replace("loop_measures", "# loop_measures").split("[[element]]")[0]
    ]
    parts += [f'[[section]]\nname = "part {n}"\nmeasures = 100\n' for n in range(MEASURES // 100)]
    for measure in range(MEASURES):
        where = f'section = "part {measure // 100}"\nmeasure = {measure % 100 + 1}\n'
        step = ("groove", "side step", "samba")[measure % 3]
        parts += [
            f'[[sequence]]\n{where}steps = ["{step}"]\n',
            f'[[at]]\n{where}beat = {1 + measure % 4}\ncall = "/dance/motion/larger"\nvalues = [0.1]\n',
            f'[[element]]\nkind = "spread"\nmeasures = 1\n{where}',
            f'[[signal]]\nname = "hit"\n{where}'
            if measure % 2
            else f'[[segment]]\nmeasures = 2\n{where}formation = "circle"\n',
        ]
    path = folder / "show.toml"
    path.write_text("\n".join(parts), encoding="utf-8")
    return path


def rows(full: bool) -> list[Row]:
    """Processor seconds from the file to the running show beyond those of the first show, and milliseconds a frame."""
    load_show(DEFAULT_PATCH).start()
    plain = _seconds(DEFAULT_PATCH)[0]
    with tempfile.TemporaryDirectory() as folder:
        path = long_score(Path(folder))
        seconds, show = min((_seconds(path) for _ in range(5 if full else 2)), key=lambda each: each[0])
    each = _frames(show)
    return [
        Row("score of 20,000 entries: loading beyond the first show", seconds - plain, "s", LOAD_BAR_S),
        Row("score of 20,000 entries: a frame, mean", float(each.mean()), "ms", FRAME_BAR_MS),
        Row("score of 20,000 entries: a frame, p99.9", float(np.percentile(each, 99.9)), "ms"),
    ]


def _seconds(path: Path) -> tuple[float, Show]:
    begin = time.process_time()
    show = load_show(path).start()
    return time.process_time() - begin, show


def _frames(show: Show) -> np.ndarray:
    """Processor time that the score alone takes in each frame [ms]: at lines, with the planning, and at every beat."""
    prompter, size = show.score_runner, show.patch.clock.beats_per_measure
    nodes = np.zeros(0, np.int32)
    taken = []
    for measure in range(1, RUN):
        for frame in range(FRAMES):
            begin = time.process_time()
            if frame == 0:
                prompter.begin_measure(measure, 0.0)
                prompter.score.regroups(measure)
            if frame == FRAMES // 2:
                prompter.score.elements(measure + 1)
                prompter.score.segments(measure + 1)
            if frame == FRAMES * 3 // 4:
                for programme in show.scheduler.programmes:
                    programme.step_for(measure + 1, nodes)
            prompter.beat_scheduler.fire((measure + frame / FRAMES) * size)
            taken.append(1e3 * (time.process_time() - begin))
    return np.array(taken)
