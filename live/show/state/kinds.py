"""All kinds of objects in the state of a show, by name and by class.

Every addition to the state of a show must be listed here; `tests/show/state` walks through the shows of all patches and
reports missing entries.
"""

from collections.abc import Callable
from typing import Any, Final, get_args

from live.base.custom_pass import CustomPassNumber
from live.control.events.event_json import field_types
from live.control.events.events import EVENT_TYPES
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.motion.cloth.spring_rig import SpringRig
from live.motion.partner.units import Units
from live.motion.partner_live.follower_model import FollowerModel
from live.motion.partner_live.stage_partner import PartnerExamples
from live.motion.pose.pose_pipeline import PoseSkeleton
from live.motion.texture.live_bank import TextureBank
from live.show.dancers.character_springs import SpringCast
from live.show.desk.parameter_table import ParameterTable
from live.show.group.group_motion import GroupMotion
from live.show.partner.example_bank import ExampleBank
from live.show.patch.patch import Patch
from live.show.patch.section_capture import AnswerSection
from live.show.patch.section_cues import CueSection
from live.show.patch.section_io import MocapSection
from live.show.patch.section_music import ReactSection
from live.show.patch.section_score import AtSection, ImproviseSection, SignalSection
from live.show.score.improviser import ImproviseTable
from live.show.score.score import WrittenScore
from live.show.score.sequence_lookup import SequenceLookup
from live.show.selection.interrupts import Interrupts
from live.show.selection.lookahead import StepCosts
from live.show.state.kind import Kind
from live.show.state.kinds_core import KINDS as CORE
from live.show.state.kinds_dance import KINDS as DANCE
from live.show.state.kinds_desk import KINDS as DESK

EVENT: Final = "event-"
"""Prefix of the kinds of events, before the event type as in journals."""


def _type_word(kind: Any) -> str:
    """Return the word of a kind's schema for the type of an event's field."""
    inside = get_args(kind)
    if type(None) in inside:
        return f"{_type_word(inside[0])}|none"
    if inside[1:] == (...,):
        return f"row[{_type_word(inside[0])}]"
    return f"tuple[{','.join(map(_type_word, inside))}]" if inside else str(kind.__name__)


_EVENTS: Final = [
    Kind(f"{EVENT}{name}", cls, " ".join(f"{field}:{_type_word(kind)}" for field, kind in field_types(name).items()))
    for name, cls in EVENT_TYPES.items()
]

CONSTANT_KINDS: Final[dict[str, type]] = {
    "constant-answer-bank": ExampleBank,
    "constant-at-section": AtSection,
    "constant-choosing": StepSelector,
    "constant-cue-section": CueSection,
    "constant-follower-model": FollowerModel,
    "constant-foresight": StepCosts,
    "constant-improvise-section": ImproviseSection,
    "constant-lore": PartnerExamples,
    "constant-mocap-section": MocapSection,
    "constant-answer-section": AnswerSection,
    "constant-motion-graph": MotionGraph,
    "constant-own-number": CustomPassNumber,
    "constant-parameter-table": ParameterTable,
    "constant-patch": Patch,
    "constant-pose-skeleton": PoseSkeleton,
    "constant-react-section": ReactSection,
    "constant-sequences": SequenceLookup,
    "constant-signal-section": SignalSection,
    "constant-spring-cast": SpringCast,
    "constant-spring-rig": SpringRig,
    "constant-table": ImproviseTable,
    "constant-texture-bank": TextureBank,
    "constant-units": Units,
    "constant-written": WrittenScore,
}
"""Classes of constants, which are referred to by name and never written."""

BY_NAME: Final = {kind.name: kind for kind in (*CORE, *DANCE, *DESK, *_EVENTS)}
BY_CLASS: Final = {kind.cls: kind for kind in BY_NAME.values()}

METHODS: Final[dict[tuple[str, str], Callable[..., Any]]] = {
    ("interrupts", "_cut"): Interrupts._cut,
    ("interrupts", "_targets"): Interrupts._targets,
    ("group-motion", "_compute_commands_ahead"): GroupMotion._compute_commands_ahead,
}
"""The bound methods that a state may hold, by kind and name."""
