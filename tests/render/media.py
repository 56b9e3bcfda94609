"""Generated images and videos for tests."""

import av
import numpy as np
from PIL import Image

FRAMES, RATE = 20, 10


def grey_of(number):
    """Grey level of a video picture, of 255."""
    return 20 + 10 * number


def write_video(path, *, size=(64, 48)):
    """A video of FRAMES pictures, each of one grey, at RATE per second."""
    with av.open(str(path), "w") as out:
        stream = out.add_stream("libx264", rate=RATE, options={"crf": "1", "g": "5"})
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        for number in range(FRAMES):
            pixels = np.full((size[1], size[0], 3), grey_of(number), np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        out.mux(stream.encode())
    return path


def write_image(path, colour=(250, 40, 10), size=(64, 36)):
    """An image of one colour, whose upper left quarter is white."""
    pixels = np.full((size[1], size[0], 3), colour, np.uint8)
    pixels[: size[1] // 2, : size[0] // 2] = 255
    Image.fromarray(pixels).save(path)
    return path
