"""An eye on a real X screen: what stands on a rectangle of it, some hundred times a second."""

import ctypes
import time
from collections.abc import Callable


class _XImage(ctypes.Structure):
    """The beginning of Xlib's XImage, up to the pixels and the length of their rows."""

    _fields_ = (
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("xoffset", ctypes.c_int),
        ("format", ctypes.c_int),
        ("data", ctypes.c_void_p),
        ("byte_order", ctypes.c_int),
        ("bitmap_unit", ctypes.c_int),
        ("bitmap_bit_order", ctypes.c_int),
        ("bitmap_pad", ctypes.c_int),
        ("depth", ctypes.c_int),
        ("bytes_per_line", ctypes.c_int),
    )


class Eye:
    """Looks at a rectangle of a screen with 32 bits a pixel; by itself at one pixel."""

    def __init__(self, display: str, x: int, y: int, width: int = 1, height: int = 1) -> None:
        self._x11 = ctypes.CDLL("libX11.so.6")
        self._x11.XOpenDisplay.restype = ctypes.c_void_p
        self._x11.XGetImage.restype = ctypes.POINTER(_XImage)
        self._x11.XDefaultRootWindow.restype = ctypes.c_ulong
        self._display = ctypes.c_void_p(self._x11.XOpenDisplay(display.encode()))
        self._root = ctypes.c_ulong(self._x11.XDefaultRootWindow(self._display))
        self._place = x, y, width, height

    def picture(self) -> bytes:
        """Its pixels, row by row, four bytes each: blue, green, red, nothing."""
        planes = ctypes.c_ulong(0x00FFFFFF)
        image = self._x11.XGetImage(self._display, self._root, *self._place, planes, 2)
        try:
            there = image.contents
            return ctypes.string_at(there.data, there.bytes_per_line * there.height)
        finally:
            self._x11.XDestroyImage(image)

    def see(self) -> str:
        """The colour of its first pixel, as in ff8000."""
        blue, green, red = self.picture()[:3]
        return f"{red:02x}{green:02x}{blue:02x}"

    def watch(self, until: Callable[[str], bool], seconds: float) -> tuple[set[str], float]:
        """All colours seen until one is what is waited for, and how long that took [s]."""
        seen: set[str] = set()
        begin = time.monotonic()
        while (now := time.monotonic()) - begin < seconds:
            colour = self.see()
            seen.add(colour)
            if until(colour):
                return seen, now - begin
        raise AssertionError(f"not within {seconds} s; seen {seen}")

    def close(self) -> None:
        """Leave the display."""
        self._x11.XCloseDisplay(self._display)
