"""Questions to the preview, as pages ask them (`live docs preview`)."""

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.errors import PersonError
from live.document.formation_answers import MAX_OPTIONS, MAX_PLACES, PlacesWish, WayOption
from live.document.preview import MAX_MEASURE
from live.document.step_answers import MAX_TAKES
from live.show.view.stage_frames import MAX_JOINT_DANCERS

MAX_EDITS: Final = 200
_Measure = Annotated[int, Field(ge=1, le=MAX_MEASURE)]


class Question(BaseModel):
    """What a page asks; see `live docs preview`."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    id: Annotated[str, Field(max_length=100)] | int | None = None
    first: _Measure | None = Field(default=None, alias="from")
    last: _Measure | None = Field(default=None, alias="to")
    measure: Annotated[float, Field(ge=1, le=MAX_MEASURE + 1)] | None = None
    """One moment: 57.5 is the middle of measure 57."""
    segment: _Measure | None = None
    """The measures of a segment of the document, by its number from 1."""
    document: Annotated[int, Field(ge=0)] | None = None
    edits: Annotated[list[Any], Field(max_length=MAX_EDITS)] = Field(default=[], alias="with")
    positions: Literal["measures", "samples", "none"] = "measures"
    """Of a range: at each measure line, or 16 times a second."""
    joints: bool | Annotated[list[int], Field(max_length=MAX_JOINT_DANCERS)] = False
    """The joints of all, or of these dancers: of one moment, or 16 times a second of a range."""
    division: bool = False
    """Of a range: how the groups are divided."""
    ways: bool = True
    notes: bool = True
    led: bool = False
    """The score as if somebody led from each section to the one written below it. Measures are counted as written."""
    planned: bool = False
    """Of a range with edits: only ways and faults as planned, from where everybody stands without the edits."""
    waveform: bool = False
    """Instead of measures: how loud the music is over its time."""
    steps: bool = False
    """Instead: what each step is like, and what may follow it."""
    step: Annotated[str, Field(max_length=100)] | None = None
    """Instead: the motion of a step ..."""
    takes: Annotated[list[Annotated[int, Field(ge=1, le=10_000)]], Field(max_length=MAX_TAKES)] = []
    """... in these takes, from 1."""
    sequence: Annotated[str, Field(min_length=1, max_length=2000)] | None = None
    """Instead: what a sequence of steps lacks."""
    places: Annotated[list[PlacesWish], Field(max_length=MAX_PLACES)] = []
    """Instead: the places of formations."""
    options: Annotated[list[WayOption], Field(max_length=MAX_OPTIONS)] = []
    """Of a segment with a formation: the ways of each option."""
    element: _Measure | None = None
    """Instead: what could follow an element of the document, by its number from 1."""
    sheets: Literal["a4", "letter"] | None = None
    """Instead: the storyboard on this paper, ..."""
    dancer: Annotated[int, Field(ge=1, le=100_000)] | None = None
    """... or the sheets of this dancer, ..."""
    pdf: bool = False
    """... or all sheets as a PDF."""


def parse_question(values: object) -> Question:
    """Return the question that was sent; PersonError with its field."""
    try:
        return Question.model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"][:2]) or "question"
        words = first["msg"][:1].lower() + first["msg"][1:]
        raise PersonError(f"{where}: {words}", "`live docs preview` has the form of questions") from None
