"""Edit: what an edited patch changes of a running show, and what of it has to wait for the next start."""

import hashlib
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.patch.section_base import Section

AT_THE_START: Final = (
    "seed", "steps", "reserve", "music", "sound", "clock", "link", "midi.input", "midi.output", "midi.clock_out",
    "midi.time_code_bpm", "midi.time_code_offset_s", "osc", "stage", "background", "item",
    "picture.passes", "character", "texture", "steering.separation", "steering.combine",
)  # fmt: skip
"""Keys that count when a show starts, and not again."""
GROUP_AT_THE_START: Final = (
    "dancers", "soloists", "radius", "partners", "arm_length", "hands", "formation", "centre", "size"
)  # fmt: skip
"""The same within a `[[group]]`."""


def fitted(new: Patch, running: Patch) -> tuple[Patch, tuple[str, ...]]:
    """The patch `new` as far as it can act in a show of the patch `running`, and the keys that wait for a new start.

    Those keep the values they run with. Groups that come or go wait all together: `group`.
    """
    waits: list[str] = []
    changes: dict[str, Any] = {}
    for key in AT_THE_START:
        name, _, inner = key.partition(".")
        old, edited = getattr(running, name), changes.get(name, getattr(new, name))
        if inner:
            kept, wanted = getattr(old, inner), getattr(edited, inner)
            if kept != wanted:
                waits.append(key)
                changes[name] = edited.model_copy(update={inner: kept})
        elif old != edited:
            waits += _keys(name, old, edited)
            changes[name] = old
    if "picture.passes" in waits:  # the texts belong to the names
        changes["picture"] = changes["picture"].model_copy(update={"own": running.picture.own})
    if len(new.gate) != len(running.gate):
        waits.append("gate")
        changes["gate"] = running.gate
    if _examples(new) != _examples(running):
        waits.append("partner")
        changes["partner"] = running.partner
    if len(new.group) != len(running.group):
        waits.append("group")
        changes["group"] = running.group
    else:
        groups = []
        for number, (group, old_group) in enumerate(zip(new.group, running.group, strict=True), start=1):
            kept = {key: getattr(old_group, key) for key in GROUP_AT_THE_START}
            kept = {key: value for key, value in kept.items() if value != getattr(group, key)}
            waits += [f"group.{number}.{key}" for key in kept]
            groups.append(group.model_copy(update=kept) if kept else group)
        changes["group"] = tuple(groups)
    return new.model_copy(update=changes), tuple(waits)


def _examples(patch: Patch) -> list[tuple[object, ...]]:
    """What each partner answers from: read when a show starts."""
    keys = "name", "examples", "steps", "stretch", "unit_beats", "by_path", "near"
    return [tuple(getattr(one, key) for key in keys) for one in patch.partner]


def _keys(name: str, old: Any, new: Any) -> list[str]:
    """The keys of a section that differ, by their names in the patch."""
    if not isinstance(old, Section):
        return [name]
    return [f"{name}.{key}" for key in type(old).model_fields if getattr(old, key) != getattr(new, key)]


def changed(old: Patch, new: Patch) -> tuple[str, ...]:
    """Names of the fields of a patch that differ."""
    return tuple(name for name in Patch.model_fields if getattr(old, name) != getattr(new, name))


def version_of(text: str) -> str:
    """A short name for a patch written as JSON."""
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()
