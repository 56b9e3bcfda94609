"""Pads of a show on a grid controller: which of them the grid shows, what a press says, and every light.

The grid has the pads of the studio's page in the same order: a column for everybody and one for each group, a row for
each pad. It shows a window of them, moved by the arrows.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from live.control.midi.grid_layout import Address, GridLayout, Light
from live.control.registry.control import ArgumentValue

PAGES: Final = ("own", "step", "phrase", "formation", "element", "look")
WHENS: Final = ("now", "beat", "measure", "section")
EVERYBODY: Final = "*"
Call = tuple[str, tuple[ArgumentValue, ...]]
"""Address and values of a command."""
_STATE_ORDER: Final = ("waits", "runs", "refused")


class GridSurface:
    """The window of one grid on the pads of a show. Thread: the show's."""

    def __init__(self) -> None:
        self.page = "step"
        """The page of pads that is shown."""
        self.when = "measure"
        """When what is pressed begins."""
        self.row = self.column = 0
        """First row and column of the window."""
        self.pads: Mapping[str, Sequence[Mapping[str, Any]]] = {}
        """The pads of each page, as `live.show.desk.launch_report.pad_facts` tells them."""
        self.columns: Sequence[str] = (EVERYBODY,)
        """The dancers of each column."""
        self.hues: Mapping[str, float | None] = {}
        """Hue of each column, 0 to 1; None: white."""
        self._stopping: bool | None = None  # whether Stop is held and nothing was stopped yet; None: not held

    # -- presses -----------------------------------------------------------------------------------------------------

    def press(self, layout: GridLayout, address: Address, pressed: bool) -> Call | None:
        """Take a press of a pad or button, or its release; return the command that it gives."""
        name = layout.buttons.get(address)
        if name is None:
            return self._press_pad(*layout.pads[address]) if pressed else None
        if name == "stop":
            return self._press_stop(pressed)
        return self._press_button(layout, name) if pressed else None

    def _press_pad(self, row: int, column: int) -> Call | None:
        who, pad = self._column(column), self._pad(row)
        if self._stopping is not None:  # Stop is held: of this column
            self._stopping = False
            return None if who is None else ("/dance/launch/stop", (who,))
        if who is None or pad is None:
            return None
        return "/dance/launch", (str(pad["pad"]), who, self.when)

    def _press_stop(self, pressed: bool) -> Call | None:
        alone, self._stopping = self._stopping, True if pressed else None
        return ("/dance/launch/stop", (EVERYBODY,)) if alone and not pressed else None

    def _press_button(self, layout: GridLayout, name: str) -> Call | None:
        rows, columns = len(self.pads.get(self.page, ())), len(self.columns)
        match name:
            case "up":
                self.row = max(self.row - layout.rows, 0)
            case "down":
                self.row = self.row + layout.rows if self.row + layout.rows < rows else self.row
            case "left":
                self.column = max(self.column - layout.columns, 0)
            case "right":
                self.column = self.column + layout.columns if self.column + layout.columns < columns else self.column
            case "undo":
                return "/dance/undo", ()
            case _ if name in WHENS:
                self.when = name
            case _:
                self.page, self.row = name, 0
        return None

    def _column(self, column: int) -> str | None:
        if self.page == "look":
            return EVERYBODY if self.column + column == 0 else None
        place = self.column + column
        return self.columns[place] if place < len(self.columns) else None

    def _pad(self, row: int) -> Mapping[str, Any] | None:
        pads = self.pads.get(self.page, ())
        return pads[self.row + row] if self.row + row < len(pads) else None

    # -- lights ------------------------------------------------------------------------------------------------------

    def lights(
        self, layout: GridLayout, told: Mapping[str, Any], *, on: bool
    ) -> dict[Address, tuple[Light, float | None]]:
        """Return every light. `told`: what `live.show.desk.launch_report.launch_facts` tells; `on`: in the bright half
        of a blink."""
        states: dict[tuple[str, str], str] = {}
        for one in told.get("launches", ()):
            key = one["pad"], one["who"].casefold()
            known = states.get(key)
            if known is None or _STATE_ORDER.index(one["state"]) < _STATE_ORDER.index(known):
                states[key] = one["state"]
        found: dict[Address, tuple[Light, float | None]] = {}
        for address, (row, column) in layout.pads.items():
            who, pad = self._column(column), self._pad(row)
            if who is None or pad is None:
                found[address] = "off", None
                continue
            found[address] = (
                self._pad_light(states.get((pad["pad"], who.casefold())), pad, who, told, on),
                self.hues.get(who),
            )
        busy = any(one["state"] != "refused" for one in told.get("launches", ()))
        for address, name in layout.buttons.items():
            found[address] = self._button_light(layout, name, busy), None
        return found

    @staticmethod
    def _pad_light(state: str | None, pad: Mapping[str, Any], who: str, told: Mapping[str, Any], on: bool) -> Light:
        match state:
            case "waits":
                return "waits" if on else "off"
            case "runs":
                return "runs"
            case "refused":
                return "refused"
        step = pad.get("does", pad["name"]) if pad["kind"] == "step" else None
        return "away" if step is not None and step in told.get("away", {}).get(who, {}) else "idle"

    def _button_light(self, layout: GridLayout, name: str, busy: bool) -> Light:
        match name:
            case "up":
                lit = self.row > 0
            case "down":
                lit = self.row + layout.rows < len(self.pads.get(self.page, ()))
            case "left":
                lit = self.column > 0
            case "right":
                lit = self.column + layout.columns < len(self.columns)
            case "stop":
                return "refused" if busy else "dim"
            case "undo":
                return "dim"
            case _:
                lit = name in (self.page, self.when)
        return "bright" if lit else "dim"
