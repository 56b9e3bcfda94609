"""Checks of single tables of a patch against the controls and parameters that they name; each raises ValueError."""

import difflib
from collections.abc import Mapping, Sequence
from typing import Any, Final

from live.agents.formations.formation_spec import spec_from_table
from live.base.custom_pass import custom_pass_numbers
from live.base.errors import PersonError
from live.base.picture_parameters import BY_ADDRESS, GROUP_PARAMETERS, STYLE_ADDRESS_PREFIX
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Reason, Rejection
from live.show.desk.look_settings import DRAW_KEYS, draw_key, draw_settings
from live.show.desk.parameter_table import check_setting, parse_value, split_key
from live.show.patch.midi_bindings import binding_of
from live.show.patch.section_base import Checks, InvalidEntry, Setting
from live.show.patch.section_cues import CueSection, SceneSection
from live.show.patch.section_motion import GroupSection
from live.show.patch.section_music import ReactSection
from live.show.patch.section_picture import PictureSection
from live.show.patch.section_score import AtSection, EvolutionSection, ImproviseMotion
from live.show.patch.section_stage import NamedLookSection


def _check_call(address: str, values: Sequence[Any], words: str) -> None:
    """Raise ValueError, with `words` in front, unless the control exists and takes these values."""
    made = REGISTRY.call(address, values, 0.0, "patch")
    if not isinstance(made, ControlEvent):
        unknown = isinstance(made, Rejection) and made.reason is Reason.UNKNOWN_ADDRESS
        near = REGISTRY.near(address) if unknown else None
        raise ValueError(f"{words}: {made}; {f'did you mean {near!r}? ' if near else ''}see `live docs osc`")


def _check_at(at: AtSection) -> None:
    if at.signal is None:
        _check_call(*at.called, f"call {at.call or '/dance/scene'!r} with {list(at.values)!r}")


def _check_improvise_motion(motion: ImproviseMotion) -> None:
    if motion.call is not None:
        _check_call(motion.call, motion.values, f"call {motion.call!r} with {list(motion.values)!r}")


def _check_cue(cue: CueSection) -> None:
    faults = []
    for index, (address, *values) in enumerate(cue.calls):
        try:
            _check_call(str(address), values, f"cue {cue.name!r}: {address!r} with {values!r}")
        except ValueError as error:
            faults.append(InvalidEntry(str(error), "calls", index))
    if faults:
        faults[0].others = tuple(faults[1:])
        raise faults[0]


def _check_react(reaction: ReactSection) -> None:
    if reaction.sets is not None and reaction.sets.startswith("/"):
        _check_reaction_address(reaction, reaction.sets)
    if reaction.call is not None:
        _check_call(reaction.call, reaction.values, f"call {reaction.call!r} with {list(reaction.values)!r}")


def _check_reaction_address(reaction: ReactSection, address: str) -> None:
    known = BY_ADDRESS.get(address)
    if known is None or known.kind != "number":
        numbers = ", ".join(one.address for one in BY_ADDRESS.values() if one.kind == "number")
        raise ValueError(f"sets {address!r}: no number of the picture is called so; there are: {numbers}")
    if reaction.group != "*":
        raise ValueError(f"sets {address!r}: light and camera belong to no group")
    for value in (reaction.low, reaction.high):
        if not known.low <= value <= known.high:
            raise ValueError(f"sets {address!r} to {value:g}: {known.low:g} to {known.high:g} expected")


def _check_scene(scene: SceneSection) -> None:
    for key, value in scene.set.items():
        try:
            check_setting(key, value)
        except PersonError as error:
            raise ValueError(f"scene {scene.name!r}: {error}") from None


def _check_draw(values: Mapping[str, Setting], where: str) -> None:
    """Raise ValueError, with `where` in front, for an unknown key or an invalid value."""
    for key, value in draw_settings(values).items():
        address = split_key(key)[0]
        if address not in GROUP_PARAMETERS or not address.startswith(STYLE_ADDRESS_PREFIX):
            raise ValueError(f"{where}: nothing is drawn by {draw_key(address)!r}; there are: {', '.join(DRAW_KEYS)}")
        try:
            check_setting(key, value)
        except PersonError as error:
            raise ValueError(f"{where}: {error}") from None


def _check_look(look: NamedLookSection) -> None:
    _check_draw(look.draw, f"look {look.name!r}")


def _check_group(group: GroupSection) -> None:
    _check_draw(group.draw, f"group {group.name!r}")


def _check_picture(picture: PictureSection) -> None:
    own = custom_pass_numbers(picture.own_passes)
    for address, value in picture.set.items():
        if address in own:
            known = own[address]
            if not isinstance(value, float) or not known.low <= value <= known.high:
                raise InvalidEntry(f"{address!r} = {value!r}: {known.low:g} to {known.high:g} expected", "set", address)
            continue
        if address not in BY_ADDRESS:
            found = difflib.get_close_matches(address, BY_ADDRESS, n=1, cutoff=0.75)
            hint = f"did you mean {found[0]!r}? " if found else ""
            raise InvalidEntry(
                f"{address!r} is no parameter of the picture; {hint}`live docs osc` lists them", "set", address
            )
        try:
            parse_value(address, value)
        except PersonError as error:
            raise InvalidEntry(str(error), "set", address) from None


def _check_formation(table: dict[str, Any]) -> None:
    try:
        spec = spec_from_table(table)
    except PersonError as error:
        raise ValueError(str(error)) from None
    if not spec.name:
        raise ValueError("a formation needs a name")


def _check_evolution(section: EvolutionSection) -> None:
    try:
        spec_from_table({"name": section.name, "like": section.like or section.name, **section.transform_table})
    except PersonError as error:
        raise ValueError(str(error).replace("formation", "evolution", 1)) from None


ENTRY_CHECKS: Final[Checks] = {
    "at": _check_at,
    "cue": _check_cue,
    "evolution": _check_evolution,
    "formation": _check_formation,
    "group": _check_group,
    "improvise.motion": _check_improvise_motion,
    "looks": _check_look,
    "midi.map": binding_of,
    "picture": _check_picture,
    "react": _check_react,
    "scene": _check_scene,
}
"""The checks by the names that the tables give to `run_check`."""
