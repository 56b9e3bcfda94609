"""Record of the last step choice of each dancer: candidates, scores by term, targets and errors.

It explains single choices on request, and reports dancers whose steps do not reach their targets, with a recording that
would help (T003, T068, T075). Recording costs a few array copies per measure.
"""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.graph.select.candidates import turn_vectors
from live.graph.select.reachability import direction_of
from live.graph.select.selector import TERMS, StepSelector, tempo_excess
from live.graph.takes import NO_TAKE
from live.motion.editing.tempo_forms import DOUBLE_TIME, HALF_TIME, TEMPO_LIMITS

BEHIND_M: Final = 0.4
"""A dancer who ends farther than this from the wished place [m] ..."""
BEHIND_MEASURES: Final = 3
"""... in this many measures in a row is behind: the steps do not reach the targets (T075)."""


class StepChoices:
    """The last choice for A dancers, and the errors of the one before."""

    def __init__(self, count: int) -> None:
        self.edge: Int32 = np.full((count, 2), -1, np.int32)
        """Edges of the graph, chosen and runner-up, -1 for none, shape (A, 2)."""
        self.candidate: Int32 = np.full((count, 2), -1, np.int32)
        """Rows of the candidates, likewise."""
        self.terms: Float64 = np.zeros((count, 2, len(TERMS)))
        """Cost of each of TERMS for both, shape (A, 2, 5)."""
        self.end: Float64 = np.zeros((count, 4))
        """End of the chosen one without correction: x, z [m], turn [rad], remaining heading error [rad], (A, 4)."""
        self.node: Int32 = np.full((count, 2), -1, np.int32)
        """Nodes, chosen and runner-up, shape (A, 2)."""
        self.start_position: Float64 = np.zeros((count, 2))
        """Position at the beginning of the measure [m], shape (A, 2)."""
        self.heading: Float64 = np.zeros(count)
        """Heading at the beginning of the measure [rad], shape (A,)."""
        self.step: Int32 = np.full(count, -1, np.int32)
        """The wanted step, -1 for any, shape (A,)."""
        self.wish: Float64 = np.zeros((count, 2))
        """Wished position at the measure's end, whatever the steps reach [m], shape (A, 2)."""
        self.target: Float64 = np.zeros((count, 2))
        """The part of the way to it that the wanted step reaches (predicted agent) [m], shape (A, 2)."""
        self.error: Float64 = np.zeros(count)
        """Distance between the target and the end of the measure before [m], shape (A,)."""
        self.lag: Float64 = np.zeros(count)
        """Distance between the wish and the end of the measure before [m], shape (A,)."""
        self.measures_behind: Int32 = np.zeros(count, np.int32)
        """Number of measures in a row that ended farther than BEHIND_M from the wish, shape (A,)."""
        self._decided = False

    @property
    def outputs(self) -> tuple[Int32, Int32, Float64, Float64]:
        """The arrays that the choice writes."""
        return self.edge, self.candidate, self.terms, self.end

    def begin(self, stand: Float64, heading: Float64, there: npt.NDArray[np.bool_]) -> None:
        """Begin a choice: the measure before will end at `stand` (A, 2) [m] with `heading` (A,).

        Errors are recorded for dancers who are `there` (A,).
        """
        if self._decided:
            self.error[:] = np.hypot(*(self.target - stand).T) * there
            self.lag[:] = np.hypot(*(self.wish - stand).T) * there
            self.measures_behind[:] = np.where(self.lag > BEHIND_M, self.measures_behind + 1, 0)
        self.start_position[:], self.heading[:] = stand, heading
        self._decided = True

    # -- explanations ------------------------------------------------------------------------------------------

    def explain(self, dancer: int, choosing: StepSelector) -> dict[str, Any]:
        """Return the explanation of a dancer's next (or present) measure, for the overlay and for JSON."""
        library = choosing.graph.library
        rows = {}
        for rank, word in enumerate(("chosen", "runner_up")):
            node = int(self.node[dancer, rank])
            rows[word] = None if node < 0 else self._explain_candidate(dancer, rank, choosing)
        step = int(self.step[dancer])
        return {
            "dancer": dancer + 1,
            "wanted": "any" if step < 0 else library.steps[step],
            **rows,
            "stands": _rounded(self.start_position[dancer]),
            "wish": _rounded(self.wish[dancer]),
            "prediction": _rounded(self.target[dancer]),
            "error_m": round(float(self.error[dancer]), 3),
            "lag_m": round(float(self.lag[dancer]), 3),
        }

    def _explain_candidate(self, dancer: int, rank: int, choosing: StepSelector) -> dict[str, Any]:
        library, candidates = choosing.graph.library, choosing.candidates
        row = int(self.candidate[dancer, rank])
        take = int(candidates.take[row])
        scores = self.terms[dancer, rank]
        mixed = {} if take == NO_TAKE else {"with": library.describe(take), "share": float(candidates.share[row])}
        return {
            "clip": library.describe(int(self.node[dancer, rank])),
            **mixed,
            "score": round(float(scores.sum()), 4),
            **{name.replace(" ", "_"): round(float(v), 4) for name, v in zip(TERMS, scores, strict=True)},
        }


def explanation_lines(explanation: dict[str, Any]) -> tuple[str, ...]:
    """Return an explanation by `StepChoices.why` as lines for the overlay."""
    lines = [
        f"dancer {explanation['dancer']}: {explanation['wanted']}, {explanation['error_m']:.2f} m off, "
        f"{explanation['lag_m']:.2f} m behind"
    ]
    for word in ("chosen", "runner_up"):
        row = explanation[word]
        if row is None:
            continue
        mixed = f" + {row['share']:.0%} {row['with']}" if "with" in row else ""
        terms = "  ".join(f"{name} {row[name.replace(' ', '_')]:.2f}" for name in TERMS)
        lines.append(f"{word.replace('_', '-')}: {row['clip']}{mixed}  {row['score']:.2f}: {terms}")
    return tuple(lines)


def _rounded(values: Float64) -> list[float]:
    return [round(float(v), 3) for v in values]


def reachability_report(
    choices: StepChoices, group: Int32, names: tuple[str, ...], steps: tuple[str, ...], present: Bool
) -> dict[str, Any]:
    """Return by group: mean distances of the last measure [m], the number of dancers behind, and a recording that would
    help.

    `group` (A,) indexes `names`; `steps` are the library's. "record" is null if no dancer is behind.
    """
    told: dict[str, Any] = {}
    for index, name in enumerate(names):
        members = (group == index) & present
        if not members.any():
            continue
        rows = np.flatnonzero(members & (choices.measures_behind >= BEHIND_MEASURES))
        told[name] = {
            "error_m": round(float(choices.error[members].mean()), 3),
            "lag_m": round(float(choices.lag[members].mean()), 3),
            "behind": len(rows),
            "record": _recording_advice(choices, rows, steps) if len(rows) else None,
        }
    return told


def tempo_report(choosing: StepSelector, nodes: Int32, bpm: float) -> list[dict[str, Any]]:
    """Return the recorded steps that dancers in `nodes` (n,) dance outside the limits of their tempo, most dancers
    first.

    `bpm` is the present tempo. "times" is how many times faster than recorded they dance, "bpm" the recorded tempo.
    """
    library = choosing.graph.library
    seconds = library.beats_per_measure * 60.0 / bpm
    recorded = choosing.recorded_seconds[nodes]
    off = np.abs(tempo_excess(recorded, seconds)) > 1e-9
    told = []
    for step in np.unique(library.node_step[nodes[off]]).tolist():
        own = off & (library.node_step[nodes] == step)
        clip = library.clips[library.node_clip[nodes[own][0]]]
        factor = {HALF_TIME: 2.0, DOUBLE_TIME: 0.5}.get(clip.tempo_form, 1.0)
        row = {
            "step": library.steps[step],
            "form": clip.tempo_form,
            "times": round(float(recorded[own][0]) / seconds, 2),
        }
        told.append({**row, "bpm": round(clip.bpm / factor, 1), "dancers": int(own.sum())})
    return sorted(told, key=lambda row: -row["dancers"])


def tempo_line(report: list[dict[str, Any]]) -> tuple[str, ...]:
    """Return the overlay's line on a report by `tempo_report`; none if all steps are near their tempo."""
    if not report:
        return ()
    row, low, high = report[0], *TEMPO_LIMITS
    more = f", and {len(report) - 1} more" if len(report) > 1 else ""
    form = f"at {row['form']} " if row["form"] else ""
    return (
        f"tempo: {row['step']!r}, recorded at {row['bpm']:.0f} bpm, is danced {form}{row['times']:.2f} times as fast "
        f"({low} to {high} is possible) by {row['dancers']}{more}: choose another step or tempo",
    )


def _recording_advice(choices: StepChoices, rows: npt.NDArray[np.intp], steps: tuple[str, ...]) -> str:
    """Return the recording that the dancers `rows` (n,) lack most: step, direction relative to the dancer, distance."""
    way = turn_vectors(choices.wish[rows] - choices.start_position[rows], -choices.heading[rows])
    got = turn_vectors(choices.target[rows] - choices.start_position[rows], -choices.heading[rows])
    directions = [direction_of(one) for one in way]
    most = max(sorted(set(directions)), key=directions.count)
    those = np.array([direction == most for direction in directions])
    needed, reached = np.hypot(*way[those].T), np.hypot(*got[those].T)
    kinds = choices.step[rows][those]
    step = int(np.bincount(kinds[kinds >= 0]).argmax()) if (kinds >= 0).any() else -1
    which = "any step" if step < 0 else f"{steps[step]!r}"
    return (
        f"{which} gets {np.median(reached):.1f} m {most} in a measure, {np.median(needed):.1f} m are needed: "
        "record it with more travel in that direction, or set a travel_step for the group that goes there"
    )
