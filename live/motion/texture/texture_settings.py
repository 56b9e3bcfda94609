"""Settings of motion texturing and parsers of their option texts (P001)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError
from live.motion.skeleton import SKELETON
from live.motion.texture.fragment_search import CANDIDATE_SHARE
from live.motion.texture.fragments import BLEND_REACH
from live.motion.texture.frequency_bands import MAX_BANDS

_NAMES: Final = SKELETON.names


def _with(*ends: str) -> tuple[int, ...]:
    return tuple(n for n, name in enumerate(_NAMES) if any(name.endswith(end) for end in ends))


LEGS: Final = _with("UpperLeg", "LowerLeg", "Foot", "Toes")
LOWER: Final = (0, *LEGS)
UPPER: Final = tuple(n for n in range(1, len(_NAMES)) if n not in LEGS)
JOINT_GROUPS: Final[dict[str, tuple[int, ...]]] = {
    "upper": UPPER,
    "lower": LOWER,
    "legs": LEGS,
    "hips": _with("UpperLeg"),
    "knees": _with("LowerLeg"),
    "ankles": _with("Foot"),
    "pelvis": (0,),
    "trunk": tuple(map(SKELETON.index, ("spine", "chest", "upperChest"))),
    "head": tuple(map(SKELETON.index, ("neck", "head"))),
    "shoulders": _with("UpperArm"),
    "elbows": _with("LowerArm"),
    "arms": _with("Shoulder", "UpperArm", "LowerArm", "Hand"),
    "none": (),
}
"""Names of joint groups. `hips` and `knees` are the upper and lower legs."""


MAX_TIME_S: Final = 36_000.0
"""Upper limit of times in a sketch [s]."""


@dataclass(frozen=True, slots=True)
class TextureSettings:
    """Parameters of the method. The defaults are the paper's."""

    drive: tuple[int, ...] = (*JOINT_GROUPS["hips"], *JOINT_GROUPS["knees"])
    """Joints whose angles are matched."""
    drive_changes: tuple[tuple[float, tuple[int, ...]], ...] = ()
    """From each time [s] on only these of `drive` are matched, in order (P019). Before: `initial_drive`."""
    initial_drive: tuple[int, ...] = ()
    """Joints matched before the first of `drive_changes`; empty: all of `drive`."""
    synthesize: tuple[int, ...] = UPPER
    """Joints synthesized from the data alone, in the first of `bands` and all lower ones."""
    texture: tuple[int, ...] = LOWER
    """Joints of the sketch whose bands are replaced by those of the data."""
    bands: tuple[int, int] = (2, 3)
    """First and last band of texture. Synthesized joints get the first and all lower bands. Band 1 is the highest."""
    match_band: int = 4
    """Band of the driving angles that is matched and cut: the 4th for walking, the 6th for modern dance."""
    cut: int | None = None
    """Column (3 joint + axis) at whose turning points curves are cut; None: the driving one that moves most."""
    keep: float = CANDIDATE_SHARE
    """K: candidates for each fragment; below 1 a share of all fragments, else their number."""
    paths: int = 1
    """P: number of paths."""
    distinct_paths: bool = False
    """Whether paths must differ in every fragment, for different dancers, instead of being the P best."""
    join_weight: float = 0.0
    """0: paths as published, with the fewest joins at any distance. Otherwise the cost of a join in median distances of
    the closest matches; 1 to 4 are useful."""
    scale: bool = False
    """Whether fragments are scaled to fit the driving angles (P010)."""
    reach: int = BLEND_REACH
    """N of the joins [samples at 24 Hz]."""
    derivative: float = 1.0
    """Weight of derivatives against values in the matching, after both are normalized to the same spread."""
    learnt: bool = False
    """Whether synthesized joints are what the lower body tells of them, with variation from the data, and the mean pose
    where it tells nothing; otherwise they come from the data alone, as published."""
    learnt_drive: tuple[int, ...] = ()
    """Joints that tell the synthesized ones; empty: chosen by cross-validation."""
    spread: float = 0.25
    """Variation of learnt joints: the share of what the prediction gains over the mean pose that it may use up."""

    def __post_init__(self) -> None:
        low, high = self.bands
        _check(1 <= low <= high <= MAX_BANDS, f"bands {low}-{high}", f"two of 1 to {MAX_BANDS}, the higher band first")
        _check(1 <= self.match_band <= MAX_BANDS, f"band {self.match_band}", f"1 to {MAX_BANDS}")
        _check(bool(self.drive), "no driving joint is given", "hips,knees")
        times = [time for time, _ in self.drive_changes]
        _check(
            all(time > 0.0 for time in times[:1]) and times == sorted(set(times))
            and all(s for _, s in self.drive_changes),
            "changes of driving joints need ascending times above 0 s and joints",
            '"hips,knees @2.5 leftUpperLeg,leftLowerLeg @4 hips"'
        )  # fmt: skip
        _check(0.0 < self.keep <= 10_000.0, f"K = {self.keep:g}", "a share below 1 or a number of fragments")
        _check(1 <= self.paths <= 64, f"{self.paths} paths", "1 to 64")
        _check(2 <= self.reach <= 100, f"N = {self.reach}", "2 to 100 samples, 5 to 20 are useful")
        _check(0.0 <= self.derivative <= 100.0, f"derivative weight {self.derivative:g}", "0 to 100")
        _check(0.0 <= self.join_weight <= 1000.0, f"join weight {self.join_weight:g}", "0 to 1000, 1 to 4 are useful")
        _check(
            0.0 <= self.spread <= 1.0, f"spread {self.spread:g}", "0 (steady) to 1 (as far from the truth as the mean)"
        )
        both = set(self.synthesize) & set(self.texture)
        _check(not both, f"{joint_names(both)} cannot be textured and synthesised", "name each joint once")
        legs = set(self.synthesize) & set(LOWER)
        _check(not legs, f"{joint_names(legs)} cannot be synthesised, because feet would slide", "texture them")
        _check(bool(self.synthesize or self.texture), "no joint is textured or synthesised", "upper or lower")
        driven = set(self.drive) & set(self.synthesize)
        _check(
            not driven,
            f"{joint_names(driven)} cannot drive and be synthesised",
            "drive with joints that the sketch moves",
        )

    def drive_at(self, seconds: float) -> tuple[int, ...]:
        """Return the joints that are matched at that time of the sketch."""
        found = self.initial_drive or self.drive
        for time, joints in self.drive_changes:
            found = joints if seconds >= time else found
        return found

    def candidates(self, fragments: int) -> int:
        """Return K for that many fragments of the data."""
        return max(1, round(self.keep * fragments if self.keep < 1.0 else self.keep))


def _check(good: bool, problem: str, allowed: str) -> None:
    if not good:
        raise PersonError(problem, allowed)


def joint_names(joints: Iterable[int]) -> str:
    """Return the names of these joints, in order."""
    return ", ".join(_NAMES[joint] for joint in sorted(joints))


def parse_joints(text: str, option: str) -> tuple[int, ...]:
    """Return the joints of words like "hips,knees" or "upper,leftFoot", in order; PersonError for an unknown word."""
    by_name: dict[str, tuple[int, ...]] = {
        name.casefold(): (index,) for index, name in enumerate(_NAMES) if name != "hips"
    }
    by_name |= {word.casefold(): joints for word, joints in JOINT_GROUPS.items()}
    found: set[int] = set()
    for word in text.replace(" ", ",").split(","):
        if word and word.casefold() not in by_name:
            raise PersonError(
                f"{option}: no joint is called {word[:40]!r}", ", ".join(JOINT_GROUPS) + f", or {_NAMES[10]} ..."
            )
        found.update(by_name.get(word.casefold(), ()))
    return tuple(sorted(found))


Changes = tuple[tuple[float, tuple[int, ...]], ...]


def parse_drive(text: str, option: str) -> tuple[tuple[int, ...], Changes]:
    """Parse "hips @2.5 leftUpperLeg,leftLowerLeg @4 hips": initial joints, and those from each time [s] on (P019)."""
    first, *later = text.split("@")
    found = []
    for part in later:
        time, _, words = part.strip().partition(" ")
        try:
            seconds = float(time)
        except ValueError:
            seconds = -1.0
        if not (0.0 < seconds <= MAX_TIME_S and words.strip()):
            raise PersonError(
                f"{option}: '@{part.strip()[:40]}': a time above 0 s and joints expected", "hips @2.5 hips,knees"
            )
        found.append((seconds, parse_joints(words, option)))
    return parse_joints(first, option), tuple(found)


def parse_bands(text: str, option: str) -> tuple[int, int]:
    """Parse "2-6" or "3"; PersonError for anything else."""
    parts = text.strip().split("-")
    if len(parts) in (1, 2) and all(part.strip().isdecimal() for part in parts):
        low, high = int(parts[0]), int(parts[-1])
        if 1 <= low <= high <= MAX_BANDS:
            return low, high
    raise PersonError(f"{option} {text[:40]!r}: bands 1 (the highest) to {MAX_BANDS} expected", f"{option} 2-3")


def parse_column(text: str, option: str, drive: Sequence[int]) -> int | None:
    """Parse "leftUpperLeg.x" as a column of a driving joint, or "auto" as None; PersonError otherwise."""
    if text.strip().casefold() == "auto":
        return None
    joint, _, axis = text.strip().rpartition(".")
    names = {_NAMES[one].casefold(): one for one in drive}
    if joint.casefold() not in names or axis.casefold() not in ("x", "y", "z"):
        one = _NAMES[drive[0]] if drive else "leftUpperLeg"
        raise PersonError(
            f"{option} {text[:40]!r}: auto, or a driving joint with its axis expected", f"{option} {one}.x"
        )
    return 3 * names[joint.casefold()] + "xyz".index(axis.casefold())
