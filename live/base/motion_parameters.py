"""Parameters of the motion of each group's dancers: a new one is one row here, and its use.

Every group has a row of these numbers; `Variation` has them for each dancer. The keys of `[motion]` in the patch, and
the controls under /dance/motion, are made from the rows.
"""

from typing import Final

from live.base.body.hand_shapes import AUTO, NO_SHAPE, SHAPE_NAMES
from live.base.parameter import Kind, Parameter

MOTION_PREFIX: Final = "/dance/motion/"
"""Their addresses begin so."""
_ROWS: list[Parameter] = []


def _row(
    name: str, kind: Kind, low: float, high: float, start: float, *, unit: str = "", words: str, text: str,
    patch: str = "", patch_text: str = "", choices: dict[str, float] | None = None, address: str = "",
) -> Parameter:  # fmt: skip
    """Add a row: its address, under /dance/motion if none is given, kind, range, start; `patch`: its key, `name` if it
    is the same."""
    row = Parameter(
        address or f"{MOTION_PREFIX}{name}", kind, low, high, (start,), unit, text, len(_ROWS), True, words,
        patch or f"motion.{name}", patch_text, choices or {}, ("value",),
    )  # fmt: skip
    _ROWS.append(row)
    return row


WARP: Final = _row(
    "warp", "number", 0, 1, 0.1, unit="beats", patch="motion.warp_beats", words="maximum lead or lag",
    text="Each dancer drifts ahead of the beat or behind it in a different way, from the next decided measure on.",
    patch_text="Each dancer is ahead of the beat or behind it by at most this many beats, individually (T055).",
)  # fmt: skip
WARP_SEQUENCE: Final = _row(
    "warp_sequence", "switch", 0, 1, 0.0, patch="motion.warp_over", choices={"measure": 0.0, "sequence": 1.0},
    words="1: over several measures, 0: within each",
    text="Whether this drift runs over several measures, or returns to the beat at every measure line.",
    patch_text="Back on the beat at every measure line, or drifting slowly over several measures (T056).",
)  # fmt: skip
LARGER: Final = _row(
    "larger", "number", -0.7, 0.5, 0.0, words="0 is as recorded",
    text="The upper body moves more or less than recorded, for all dancers alike.",
    patch_text="The upper body moves more than recorded by this share (below 0: less), the same for all dancers.",
)  # fmt: skip
AMPLITUDE: Final = _row(
    "amplitude", "number", 0, 0.5, 0.15, words="maximum change",
    text="The upper body moves more or less than recorded, differently for each dancer.",
    patch_text="Largest random change of the upper body's amplitude, as a share (T058).",
)  # fmt: skip
AMPLITUDE_SEQUENCE: Final = _row(
    "amplitude_sequence", "switch", 0, 1, 0.0, patch="motion.amplitude_over",
    choices={"measure": 0.0, "sequence": 1.0}, words="1: over several measures, 0: new for each",
    text="Whether that amplitude changes slowly over several measures, or is new for each.",
    patch_text="Drawn again for every measure (T060), or changing slowly over several (T059).",
)  # fmt: skip
MIX: Final = _row(
    "mix", "number", 0, 1, 0.0, words="from none to all",
    text="Maximum share of another take of the same step that is mixed into the body.",
    patch_text="Largest share of another take of the same step mixed into the whole body, drawn for every measure "
    "(T045).",
)  # fmt: skip
ARMS: Final = _row(
    "arms", "number", 0, 1, 0.0, words="from none to all",
    text="Share of the dancers whose upper body dances another take of the step.",
    patch_text="Share of the dancers whose upper body dances another take of the same step (T044).",
)  # fmt: skip
TEXTURE: Final = _row(
    "texture", "number", 0, 1, 0.0, words="steps to recorded dancers",
    text="How far upper bodies follow the recordings in [texture], chosen beat by beat to match the legs.",
    patch_text="Share of upper-body motion taken from the recordings in `[texture]`, matched to the legs beat by beat "
    "(P024); 0: that of the steps.",
)  # fmt: skip
HEAD: Final = _row(
    "head", "number", 0, 1, 0.0, words="from none to all",
    text="How far heads turn to the public, within the neck's limits.",
    patch_text="How far heads turn to the audience, within the range of the neck (T123-T125).",
)  # fmt: skip
OBEDIENCE: Final = _row(
    "obedience", "number", 0, 1, 0.5, patch="locomotion.obedience", words="faithful steps to obedient path",
    text="How far a dancer's path is corrected from their steps to the group's target; the status shows the cost.",
    patch_text="0: steps are danced as recorded, with little correction; 1: dancers are moved to their target "
    "positions as far as legs reach, within the measure, too.",
)  # fmt: skip
FOOT_LOCK: Final = _row(
    "foot_lock", "switch", 0, 1, 1.0, words="1: hold them, 0: let them slide",
    text="Whether supporting feet stay in place.",
    patch_text="Planted feet stay in place, and no sole goes below the floor.",
)  # fmt: skip
TURN_ON_SUPPORT: Final = _row(
    "turn_on_support", "switch", 0, 1, 1.0, patch="motion.turn_on", choices={"support": 1.0, "measure": 0.0},
    words="1: on that foot, 0: evenly",
    text="Whether dancers turn on the supporting foot, or evenly over the measure.",
    patch_text="Dancers turn on the supporting foot (T048-T050), or evenly over the measure.",
)  # fmt: skip
FACE_AVERAGE: Final = _row(
    "face_average", "switch", 0, 1, 0.0, patch="motion.face", choices={"end": 0.0, "average": 1.0},
    words="1: on the average, 0: at their ends",
    text="Whether dancers face the wanted direction on average over a measure, or at its end.",
    patch_text="What is aligned with the target heading: the end of each measure, or its average (T122).",
)  # fmt: skip
MIRRORED: Final = _row(
    "mirror", "choice", -1, 1, 0.0, choices={"both": 0.0, "never": -1.0, "only": 1.0},
    words="-1: never, 0: both, 1: only",
    text="Whether steps are danced as recorded, mirrored, or both.",
    patch_text="Steps and their mirror images, only the originals, or only the mirror images where they exist (T042).",
)  # fmt: skip

ARM_CLEARANCE: Final = _row(
    "arm_clearance", "number", 0, 1, 1.0, words="0: as danced, 1: never through anybody",
    text="How far arms keep off the own body, and off others' arms and bodies.",
    patch_text="How far arms are kept out of the own trunk and off other dancers; hands that are held stay together.",
)  # fmt: skip

HAND_SHAPE: Final = _row(
    "hand_shape", "choice", NO_SHAPE, len(SHAPE_NAMES) - 1, NO_SHAPE,
    choices={AUTO: float(NO_SHAPE), **{name: float(index) for index, name in enumerate(SHAPE_NAMES)}},
    words=", ".join(f"{index}: {name}" for index, name in enumerate((AUTO, *SHAPE_NAMES), NO_SHAPE)),
    text="Shape of the hands where a step says none; auto: relaxed, straighter in wide and energetic movements.",
    patch_text="Shape of the hands where a step says none; `auto`: relaxed, straighter in wide and energetic "
    "movements.",
)  # fmt: skip
FOOT_POINT: Final = _row(
    "foot_point", "number", -1, 1, 0.35, address="/dance/feet/point", words="-1: flexed, 0: as danced, 1: pointed",
    text="How far feet in the air are pointed or flexed beyond what the step does.",
    patch_text="How far feet in the air are pointed beyond what the step does: 1 as in ballet, 0 not at all; below 0 "
    "they are flexed.",
)  # fmt: skip
SMILE: Final = _row(
    "smile", "number", -1, 1, 0.25, address="/dance/face/smile", words="-1: sad, 1: beaming",
    text="How much dancers smile; mood and music add to it.",
    patch_text="How much dancers smile, from -1 to 1; mood and music add to it.",
)  # fmt: skip
FACE_EFFORT: Final = _row(
    "face_effort", "number", 0, 2, 1.0, address="/dance/face/effort", words="0: none, 1: natural, 2: twice as much",
    text="How much of the dance's effort faces show: brows, mouth, breath.",
    patch_text="How much of the dance's effort faces show in brows and mouth: 0 nothing, 1 as people do.",
)  # fmt: skip
PUBLIC_GAZE: Final = _row(
    "public_gaze", "number", 0, 2, 1.0, address="/dance/face/gaze", words="0: never, 1: often, 2: nearly always",
    text="How often eyes look at the public while heads face it.",
    patch_text="How often eyes look at the public while heads face it: 0 never, 1 often, 2 nearly always.",
)  # fmt: skip


def _mood(name: str, low: str, high: str, text: str) -> Parameter:
    """Add a row of a mood: what it is at -1 and at 1, and what it does."""
    return _row(
        f"mood_{name}", "number", -1, 1, 0.0, patch=f"mood.{name}", words=f"-1: {low}, 1: {high}",
        text=f"Mood from {low} to {high}: {text}",
        patch_text=f"From {low} (-1) to {high} (1): {text}",
    )  # fmt: skip


MOODS: Final = (
    _mood("weight", "light", "strong", "how low the body is, and how heavily its arms hang."),
    _mood("time", "sustained", "sudden", "whether movements flow through the beats or are over early and held."),
    _mood("space", "indirect", "direct", "whether trunk and gaze roam, or go straight to the public."),
    _mood("flow", "bound", "free", "whether arms stay close and tense, or swing out."),
    _mood("confidence", "shy", "proud", "chest, shoulders, and where the head looks."),
    _mood("energy", "tired", "awake", "how large movements are, and how upright the trunk."),
)
"""Laban's four efforts and two moods of the thesis' shy and graceful dancers (T143), in the order of `MoodPose`."""
MOOD_NAMES: Final = tuple(row.patch.partition(".")[2] for row in MOODS)
"""Their names: weight, time, space, flow, confidence, energy."""

MOTION_PARAMETERS: Final = tuple(_ROWS)
"""All of them, in the order of a group's row."""
MOTION_SIZE: Final = len(MOTION_PARAMETERS)
MOTION_BY_ADDRESS: Final = {row.address: row for row in MOTION_PARAMETERS}
MOTION_KEYS: Final = {
    row.patch.partition(".")[2]: row for row in MOTION_PARAMETERS if row.patch.startswith("motion.") and row.fades
}
"""Those that the music can move, by their keys in `[motion]`."""
