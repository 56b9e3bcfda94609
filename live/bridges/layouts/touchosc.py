"""Writer for TouchOSC layout files (.tosc) of a `Surface`, with py2tosc."""

import math
from pathlib import Path
from typing import Any, Final

from live.control.web.surface import Page, Surface, Widget

SIZE: Final = (0, 0, 1366, 1024)
COLUMNS: Final = 6
COLOURS: Final = {"fader": "#59A6D9", "toggle": "#E0A33E", "button": "#8FBF6B", "pad": "#C77DBA", "colour": "#D9D9D9"}
SUBSCRIBE: Final = "/dance/subscribe"

# Three faders form one colour: moving one sends all three, and a received colour is shown on all three.
_COLOUR: Final = """function onReceiveNotify()
  local function of(name) return {low} + self.children[name].values.x * {span} end
  sendOSC('{address}', of('red'), of('green'), of('blue'))
end
function onReceiveOSC(message)
  if message[1] ~= '{address}' or #message[2] < 3 then return end
  for i, name in ipairs({{'red', 'green', 'blue'}}) do
    self.children[name].values.x = (message[2][i].value - {low}) / {span}
  end
  return true
end
"""
_PART: Final = """function onValueChanged(key)
  if key == 'x' and self.values.touch then self.parent:notify('moved') end
end
"""


def write_touchosc(surface: Surface, file: Path) -> None:
    """Write the layout; OSError if the file cannot be written."""
    import py2tosc
    from py2tosc import ui

    connect = py2tosc.button(name="hear", color="#FF5555", messages=[
        ui.osc(SUBSCRIBE, args=[ui.const("/dance"), ui.const("3600", conversion="INTEGER")], on="RISE", receive=False)
    ])  # fmt: skip
    pages = [_page(page) for page in surface.pages]
    root = ui.column(ui.labelled(connect, "hear the show", size=18), ui.pager(*pages), sizes=(1, 18), frame=SIZE)
    document = py2tosc.Document(root=root)
    document.resolve()
    document.save(file)


def _page(page: Page) -> Any:
    from py2tosc import ui

    columns = min(COLUMNS, math.ceil(math.sqrt(len(page.widgets))))
    return ui.tiles(*map(_widget, page.widgets), columns=columns, gap=6, pad=6, name=page.title, tab_label=page.title)


def _widget(widget: Widget) -> Any:
    import py2tosc
    from py2tosc import ui

    look = {"name": widget.label, "color": COLOURS[widget.kind]}
    size = 14
    if widget.kind == "colour":
        return ui.labelled(_colour(widget), widget.label, size=size)
    if widget.kind == "button":
        args = [ui.const(value) for value in widget.values]
        message = ui.osc(widget.address, args=args, on="RISE", receive=False)
        return ui.labelled(py2tosc.button(messages=[message], **look), widget.label, size=size)
    if widget.kind == "toggle":
        message = ui.osc(widget.address, args=[ui.value("x", conversion="INTEGER")])
        toggle = py2tosc.button(messages=[message], button_type=py2tosc.ButtonType.TOGGLE_PRESS, **look)
        return ui.labelled(toggle, widget.label, size=size)
    ranges = zip(widget.minimum, widget.maximum, strict=True)
    if widget.kind == "pad":
        (left, right), (back, front) = ranges
        # y grows upwards in TouchOSC; the audience is below
        args = [ui.value("x", scale=(left, right)), ui.value("y", scale=(front, back))]
        on, var = ("FALL", "touch") if widget.once else ("ANY", "x")
        message = ui.osc(widget.address, args=args, receive=False, on=on, var=var)
        return ui.labelled(py2tosc.xy(messages=[message], **look), widget.label, size=size)
    ((low, high),) = ranges
    fader = py2tosc.fader(messages=[ui.osc(widget.address, args=[ui.value("x", scale=(low, high))])], **look)
    place = fader.value("x")
    if widget.start and high > low and place is not None:
        place.default = (widget.start[0] - low) / (high - low)
    return ui.labelled(fader, widget.label, size=size)


def _colour(widget: Widget) -> Any:
    import py2tosc
    from py2tosc import ui

    faders = [
        py2tosc.fader(name=name, color=ink, script=_PART)
        for name, ink in (("red", "#E05555"), ("green", "#55C055"), ("blue", "#5577E0"))
    ]
    low, high = widget.minimum[0], widget.maximum[0]
    script = _COLOUR.format(address=widget.address, low=low, span=high - low)
    # bound to its address so that the script receives messages; it sends nothing by itself
    hears = ui.osc(widget.address, args=[], triggers=[], send=False)
    return ui.row(*faders, gap=3, name=widget.label, script=script, messages=[hears])
