"""Edits: somebody saves the patch while the show runs: good ones, bad ones, and back to what it was."""

import shutil
from pathlib import Path
from typing import Final

import numpy as np

from live.show.patch.patch_search_path import MAIN_FILE

SALT: Final = 0xED17
GOOD: Final = (
    '[[formation]]\nname = "rehearsed {n}"\nshape = "circle"\nsize = [{a:.2f}, {a:.2f}]\n',
    '[[view]]\nname = "seen {n}"\neye = [{a:.2f}, 3.0, 10.0]\ntarget = [0.0, 0.9, 0.0]\n',
    '[[looks]]\nname = "dusk {n}"\nkey_light = [1.0, {b:.2f}, 0.2]\nmeasures = 1\n',
    '[[scene]]\nname = "low {n}"\nmeasures = 2\n[scene.set]\n"/dance/light/level" = {b:.2f}\n',
    '[[scene]]\nname = "wide {n}"\n[scene.set]\n"/dance/motion/larger" = {b:.2f}\n'
    '[[cue]]\nname = "wide {n}"\nscene = "wide {n}"\ncount_in = 4\n',
    '[[react]]\nto = "loudness"\nsets = "larger"\nlow = 0.0\nhigh = {b:.2f}\n',
    '[[signal]]\nname = "heard {n}"\n[[react]]\non = "heard {n}"\ncall = "/dance/spread"\nvalues = [2]\n',
    '[[element]]\nkind = "attract"\nmeasure = 1\nmeasures = 2\nat = [{a:.2f}, 0.0]\nstrength = 0.5\n',
    '[[at]]\nmeasure = 2\nbeat = 2.5\ncall = "/dance/light/level"\nvalues = [{b:.2f}, 1]\n',
)
"""Tables that any patch may be given; n: a number, a: 1 to 4, b: 0.1 to 0.4."""
BAD: Final = (
    "[[element]\n", "loop_measures = -3\n", '[[group]]\nname = "x"\n', '[[segment]]\nmeasure = 1\nmeasures = -2\n',
    '[[sequence]]\nmeasure = 1\nsteps = ["no such step"]\n', "\x00\x01\x02", "[stage]\nwidth = nan\n", "ünïcode ¤ = =",
    '[[cue]]\nname = "a"\nscene = "nowhere"\n', "[locomotion]\nthreshold_m = 1e-9\n", "[" * 3000,
)  # fmt: skip
"""What nobody wants."""


class Edits:
    """A copy of a patch in a folder, which is edited."""

    def __init__(self, path: Path, folder: Path, seed: int) -> None:
        """`path`: the patch; it is left as it is."""
        self._chance = np.random.default_rng([seed, SALT])
        if path.name == MAIN_FILE:
            shutil.copytree(path.parent, folder, dirs_exist_ok=True)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, folder / path.name)
        self.path = folder / path.name
        """The copy."""
        self._text = self.path.read_text(encoding="utf-8")
        self.saved = {"good": 0, "bad": 0, "back": 0}
        """How often it was edited how."""

    def good(self) -> None:
        """Save something that can be danced."""
        chance = self._chance
        number, size, share = int(chance.integers(100)), chance.uniform(1.0, 4.0), chance.uniform(0.1, 0.4)
        table = GOOD[int(chance.integers(len(GOOD)))].format(n=number, a=float(size), b=float(share))
        self._save("good", f"{self._text}\n{table}")

    def bad(self) -> None:
        """Save something that cannot."""
        chance = self._chance
        which = int(chance.integers(len(BAD) + 1))
        if which == len(BAD):
            self._save("bad", self._text[: int(chance.integers(len(self._text)))] + "\n[[")
        else:
            self._save("bad", f"{self._text}\n{BAD[which]}")

    def back(self) -> None:
        """Save what it was."""
        self._save("back", self._text)

    def _save(self, kind: str, text: str) -> None:
        self.saved[kind] += 1
        self.path.write_text(text, encoding="utf-8")
