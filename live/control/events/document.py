"""Commands that edit the show's files while it runs.

The show itself ignores them: what they change comes as PatchChanged.
"""

from typing import Annotated, Final

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument

MAX_EDIT_LENGTH: Final = 15_000
"""Maximum length of an edit by OSC [characters], within one packet; a stroke of 512 points with millimetres fits."""
_EDIT: Final = "as JSON (`live docs document`); the answer is in /dance/status/document_answers"
Person = Annotated[str, Argument.label("who edits, as in the edits; left out: everybody")]


@command("/dance/document/edit", "operator")
class EditDocument(ControlEvent):
    """Edits the show's files: checked, saved, and danced from the next measure that is not planned yet."""

    edit: Annotated[str, Argument.text(_EDIT, longest=MAX_EDIT_LENGTH)]


@command("/dance/document/undo", "operator")
class UndoDocument(ControlEvent):
    """Takes back a person's last edit of the show's files, unless it has been danced."""

    by: Person = ""


@command("/dance/document/redo", "operator")
class RedoDocument(ControlEvent):
    """Repeats the edit of the show's files that a person took back last."""

    by: Person = ""


@command("/dance/document/restore", "operator")
class RestoreDocument(ControlEvent):
    """Returns the show's files to an earlier revision, as a new revision."""

    revision: Annotated[int, Argument.number("a number of the history", 0, 100_000_000)]
    by: Person = ""


@command("/dance/document/music", "operator")
class ReplaceMusic(ControlEvent):
    """Replaces the music and its measures in the show's files; it plays from the next start on."""

    file: Annotated[str, Argument.label("a music file in the show's folder")]
    lines: Annotated[str, Argument.label("a file with its measure lines; left out: as the tracker proposes them")] = ""
    by: Person = ""


Name = Annotated[str, Argument.label("its name in the show's files")]


@command("/dance/document/keep/measures", "operator")
class KeepMeasures(ControlEvent):
    """Writes the last measures danced into the show's files, as a section: steps, segments, elements and calls."""

    measures: Annotated[int, Argument.number("how many whole measures", 1, 1000)]
    name: Name
    by: Person = ""


@command("/dance/document/keep/ways", "operator")
class KeepWays(ControlEvent):
    """Writes the ways that dancers have taken in the last measures into the show's files, as an evolution: curves with
    few points, which can be edited, transformed and danced again."""

    measures: Annotated[int, Argument.number("how many whole measures", 1, 64)]
    name: Name
    group: Annotated[str, Argument.label("the dancers")] = "*"
    by: Person = ""


@command("/dance/document/keep/formation", "operator")
class KeepFormation(ControlEvent):
    """Writes a formation that was defined live into the show's files."""

    name: Name
    by: Person = ""


@command("/dance/document/keep/scene", "operator")
class KeepScene(ControlEvent):
    """Writes a scene that was stored live into the show's files."""

    name: Name
    by: Person = ""


@command("/dance/document/keep/cue", "operator")
class KeepCue(ControlEvent):
    """Writes the present light, camera and motion into the show's files, as a cue with a scene of its own."""

    name: Name
    by: Person = ""
