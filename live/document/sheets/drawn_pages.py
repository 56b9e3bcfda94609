"""Drawing of pages: into a PDF with embedded fonts, as pictures, and as values that a browser draws. All draw the same
page model."""

import io
import itertools
import math
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Final

from PIL import Image, ImageDraw, ImageFont, PngImagePlugin

from live.document.sheets.page import (
    Disc,
    Ink,
    Item,
    Page,
    Point,
    Shape,
    Stroke,
    Words,
    font_face,
    font_file,
    text_width,
)

CREATOR: Final = "ChoreoGraphics Live"
DPI: Final = 150
"""Resolution of pictures."""
FINER: Final = 2
"""Pictures are drawn so many times larger, for smooth edges."""


def pdf_of(pages: Sequence[Page], title: str) -> bytes:
    """Return pages as a PDF: the same bytes for the same pages. Only letters in use are embedded."""
    from reportlab.pdfgen.canvas import Canvas

    out = io.BytesIO()
    size, font = (pages[0].width, pages[0].height), font_face(False).fontName
    canvas = Canvas(out, size, invariant=1, pageCompression=1, lang="en", initialFontName=font)
    canvas.setTitle(title)
    canvas.setCreator(CREATOR)
    canvas.setAuthor(CREATOR)
    canvas.setSubject("Sheets for dancers")
    canvas.setLineCap(1)
    for page in pages:
        canvas.setPageSize((page.width, page.height))
        canvas.setLineJoin(1)
        for item in page.items:
            _to_pdf(canvas, item, page.height)
        canvas.showPage()
    canvas.save()
    return out.getvalue()


def _to_pdf(canvas: Any, item: Item, height: float) -> None:
    match item:
        case Stroke():
            canvas.setStrokeColorRGB(*item.ink)
            canvas.setLineWidth(item.width)
            canvas.setDash([item.dash, item.dash] if item.dash else [])
            path = _pdf_path(canvas, item.points, height)
            canvas.drawPath(path, stroke=1, fill=0)
            canvas.setDash([])
        case Shape():
            _pdf_paint(canvas, item)
            path = _pdf_path(canvas, item.points, height)
            path.close()
            canvas.drawPath(path, stroke=int(item.ink is not None), fill=int(item.fill is not None))
        case Disc():
            _pdf_paint(canvas, item)
            (x, y), ink, fill = item.centre, int(item.ink is not None), int(item.fill is not None)
            canvas.circle(x, height - y, item.radius, stroke=ink, fill=fill)
        case Words():
            canvas.setFillColorRGB(*item.ink)
            canvas.setFont(font_face(item.bold).fontName, item.size)
            draw = {"l": canvas.drawString, "m": canvas.drawCentredString, "r": canvas.drawRightString}[item.anchor]
            draw(item.at[0], height - item.at[1], item.words)


def _pdf_paint(canvas: Any, item: Shape | Disc) -> None:
    if item.fill is not None:
        canvas.setFillColorRGB(*item.fill)
    if item.ink is not None:
        canvas.setStrokeColorRGB(*item.ink)
        canvas.setLineWidth(item.width)


def _pdf_path(canvas: Any, points: tuple[Point, ...], height: float) -> Any:
    path = canvas.beginPath()
    path.moveTo(points[0][0], height - points[0][1])
    for x, y in points[1:]:
        path.lineTo(x, height - y)
    return path


def picture_of(page: Page) -> bytes:
    """Return a page as a PNG of `DPI`."""
    scale = DPI * FINER / 72.0
    size = round(page.width * DPI / 72.0) * FINER, round(page.height * DPI / 72.0) * FINER
    image = Image.new("RGB", size, (255, 255, 255))
    pen = ImageDraw.Draw(image)
    for item in page.items:
        _to_picture(pen, item, scale)
    made = PngImagePlugin.PngInfo()
    made.add_text("Software", CREATOR)
    out = io.BytesIO()
    image.reduce(FINER).save(out, "PNG", dpi=(DPI, DPI), pnginfo=made, compress_level=6)
    return out.getvalue()


def _to_picture(pen: ImageDraw.ImageDraw, item: Item, scale: float) -> None:
    match item:
        case Stroke():
            for part in _dashes(item.points, item.dash) if item.dash else [item.points]:
                _picture_line(pen, part, item.width, item.ink, scale)
        case Shape():
            points = [(x * scale, y * scale) for x, y in item.points]
            if item.fill is not None:
                pen.polygon(points, fill=_rgb(item.fill))
            if item.ink is not None:
                _picture_line(pen, (*item.points, item.points[0]), item.width, item.ink, scale)
        case Disc():
            (x, y), half = item.centre, item.radius + (item.width / 2.0 if item.ink is not None else 0.0)
            box = ((x - half) * scale, (y - half) * scale, (x + half) * scale, (y + half) * scale)
            fill, ink = (None if one is None else _rgb(one) for one in (item.fill, item.ink))
            pen.ellipse(box, fill, ink, max(round(item.width * scale), 1))
        case Words():
            font = _picture_font(item.bold, item.size * scale)
            pen.text((item.at[0] * scale, item.at[1] * scale), item.words, _rgb(item.ink), font, item.anchor + "s")


def _picture_line(
    pen: ImageDraw.ImageDraw, points: Iterable[Point], width: float, ink: tuple[float, ...], scale: float
) -> None:
    there = [(x * scale, y * scale) for x, y in points]
    thick = max(round(width * scale), 1)
    pen.line(there, _rgb(ink), thick, joint="curve")
    half = thick / 2.0
    if half >= 2.0:  # round ends, as in the PDF
        for x, y in (there[0], there[-1]):
            pen.ellipse((x - half, y - half, x + half, y + half), fill=_rgb(ink))


def _dashes(points: tuple[Point, ...], dash: float) -> list[tuple[Point, Point]]:
    """Return the dashes of a line; gaps are as long as dashes."""
    found, begun = [], 0.0
    for a, b in itertools.pairwise(points):
        length = math.dist(a, b)
        at = begun
        while at < length:
            low, high = max(at, 0.0) / length, min(at + dash, length) / length
            if high > low:
                found.append((_between(a, b, low), _between(a, b, high)))
            at += 2.0 * dash
        begun = at - length - (2.0 * dash if at - length >= dash else 0.0)
    return found


def _between(a: Point, b: Point, share: float) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def _rgb(ink: tuple[float, ...]) -> tuple[int, int, int]:
    red, green, blue = (round(255.0 * min(max(one, 0.0), 1.0)) for one in ink)
    return red, green, blue


@cache
def _picture_font(bold: bool, size: float) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(font_file(bold)), size, layout_engine=ImageFont.Layout.BASIC)


def page_values(page: Page) -> dict[str, Any]:
    """Return a page as values for JSON: its size, items in order, and areas of scenes [pt]; inks are `#rrggbb`.

    A browser has other fonts, so words come with their widths.
    """
    areas = [[one.scene, *_rounded(*one.corner, one.width, one.height)] for one in page.areas]
    items = [_item_values(item) for item in page.items]
    return {"width": round(page.width, 2), "height": round(page.height, 2), "items": items, "areas": areas}


def _item_values(item: Item) -> list[Any]:
    match item:
        case Stroke():
            return ["stroke", _flat(item.points), round(item.width, 2), _web_ink(item.ink), round(item.dash, 2)]
        case Shape():
            return ["shape", _flat(item.points), _web_ink(item.fill), _web_ink(item.ink), round(item.width, 2)]
        case Disc():
            size = _rounded(*item.centre, item.radius)
            return ["disc", *size, _web_ink(item.fill), _web_ink(item.ink), round(item.width, 2)]
        case Words():
            width = text_width(item.words, item.size, item.bold)
            place = _rounded(*item.at, item.size, width)
            return ["words", *place, item.words, int(item.bold), _web_ink(item.ink), item.anchor]


def _flat(points: tuple[Point, ...]) -> list[float]:
    return _rounded(*itertools.chain.from_iterable(points))


def _rounded(*values: float) -> list[float]:
    return [round(float(value), 2) for value in values]


def _web_ink(ink: Ink | None) -> str | None:
    return None if ink is None else "#" + bytes(_rgb(ink)).hex()
