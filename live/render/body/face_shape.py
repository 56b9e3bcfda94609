"""Shapes of faces: a small table of numbers for each body and face, and the deformation that they describe.

Every face is the usual one (`head_cage.py`), deformed smoothly: bumps around landmarks. Eyes keep their places, because
all dancers share the joints that turn them.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.body.catalogue import DEFAULT_BODY
from live.render.body.head_cage import CHIN, EYE_CENTRE

FACE_COUNT: Final = 4
"""Faces of each body."""


@dataclass(frozen=True, slots=True)
class FaceShape:
    """Differences from the usual face, a young woman's; 0 is usual, about -1 to 1."""

    skull: float = 0.0
    """Size of the braincase: 1 is an eighth larger."""
    jaw: float = 0.0
    """Width of the jaw."""
    chin: float = 0.0
    """Length and strength of the chin."""
    cheekbones: float = 0.0
    cheeks: float = 0.0
    """Fullness of the cheeks; below 0 they are hollow."""
    brow: float = 0.0
    """How far the brow ridge stands out."""
    forehead: float = 0.0
    """How far the forehead bulges; below 0 it leans back."""
    nose_length: float = 0.0
    nose_width: float = 0.0
    nose_bridge: float = 0.0
    """Height of its bridge: above 0 it is arched, below 0 hollow."""
    nose_tip: float = 0.0
    """How far its tip is turned up."""
    lips: float = 0.0
    """Fullness of the lips."""
    mouth: float = 0.0
    """Width of the mouth."""
    corners: float = 0.6
    """How far the corners of the mouth are turned up, as in a face that is about to smile; 0: level."""
    eyes: float = 0.0
    """How wide the eyes are open."""
    eye_tilt: float = 0.0
    """How far their outer corners are turned up."""
    age: float = 0.0
    """Sagging cheeks, folds beside the mouth, deeper eye sockets: 0 young, 1 old."""
    neck: float = 0.0
    """Adam's apple and muscles of the neck."""


_WOMEN: Final = (
    FaceShape(),
    FaceShape(jaw=-0.3, chin=-0.2, cheekbones=0.7, cheeks=-0.3, nose_length=0.2, nose_width=-0.3, nose_bridge=0.3,
              lips=-0.3,
              eye_tilt=0.7, corners=0.35),
    FaceShape(jaw=0.3, cheekbones=0.2, cheeks=0.5, nose_length=-0.3, nose_width=0.8, nose_bridge=-0.7, lips=0.9,
              mouth=0.4),
    FaceShape(jaw=0.1, chin=0.5, cheekbones=-0.4, brow=0.2, nose_length=0.6, nose_bridge=0.8, nose_tip=-0.4, lips=-0.1,
              mouth=-0.3, eyes=-0.3, eye_tilt=-0.3),
)  # fmt: skip
_MEN: Final = (
    FaceShape(jaw=0.8, chin=0.6, brow=0.8, forehead=-0.3, nose_length=0.4, nose_width=0.4, nose_bridge=0.3, lips=-0.4,
              mouth=0.3, eyes=-0.3, neck=0.8),
    FaceShape(jaw=0.5, chin=0.9, cheekbones=0.4, cheeks=-0.7, brow=0.6, forehead=-0.5, nose_length=0.8, nose_bridge=0.9,
              nose_tip=-0.5, lips=-0.6, eyes=-0.3, neck=1.0),
    FaceShape(jaw=1.1, chin=0.4, cheekbones=0.3, cheeks=0.4, brow=0.9, nose_width=1.1, nose_bridge=-0.5, lips=0.6,
              mouth=0.7,
              eyes=-0.2, neck=0.7),
    FaceShape(jaw=0.4, chin=0.3, brow=0.5, forehead=0.1, nose_length=0.1, nose_width=0.1, nose_tip=0.4, lips=-0.1,
              eyes=-0.1,
              eye_tilt=0.4, neck=0.6),
)  # fmt: skip
_CHILDREN: Final = tuple(
    replace(
        face, skull=0.55, jaw=0.6 * face.jaw - 0.7, chin=-1.2, cheekbones=-0.5, cheeks=0.9 + 0.3 * face.cheeks,
            brow=-0.6,
        forehead=0.9, nose_length=-1.2 + 0.4 * face.nose_length, nose_width=0.5 * face.nose_width,
        nose_bridge=-0.9 + 0.3 * face.nose_bridge, nose_tip=0.8, mouth=-0.5, eyes=0.5,
    )
    for face in _WOMEN
)  # fmt: skip


def _with_all(faces: tuple[FaceShape, ...], **more: float) -> tuple[FaceShape, ...]:
    return tuple(replace(face, **{key: getattr(face, key) + by for key, by in more.items()}) for face in faces)


FACES: Final[dict[str, tuple[FaceShape, ...]]] = {
    DEFAULT_BODY: _WOMEN,
    "woman": _with_all(_WOMEN, cheeks=0.2, chin=0.1),
    "slim": _with_all(_WOMEN, cheeks=-0.4, jaw=-0.2),
    "round": _with_all(_WOMEN, cheeks=0.9, jaw=0.5, chin=-0.3, neck=-0.5),
    "child": _CHILDREN,
    "man": _MEN,
    "strong": _with_all(_MEN, jaw=0.2, cheeks=-0.1),
    "older woman": _with_all(_WOMEN, age=0.9, nose_length=0.4, lips=-0.6, eyes=-0.3),
    "older man": _with_all(_MEN, age=0.9, nose_length=0.3, lips=-0.3),
}
"""Faces of each body, by its name."""


def faces_of(body: str) -> tuple[FaceShape, ...]:
    """Return the faces of a body, `FACE_COUNT` of them."""
    return FACES.get(body, _WOMEN)


_X, _Y, _Z = np.eye(3)
_EYE_KEPT: Final = 0.021
_SKULL_CENTRE: Final = np.array([0.0, EYE_CENTRE[1], 0.040])


def _bump(p: Float64, centre: tuple[float, float, float], reach: tuple[float, float, float]) -> Float64:
    """Return a weight that falls smoothly from 1 around a place on the left and its mirror image, shape (N, 1)."""
    apart = (np.column_stack([np.abs(p[:, 0]), p[:, 1:]]) - np.array(centre)) / np.array(reach)
    return np.asarray(np.exp(-(apart**2).sum(axis=1))[:, None])


def _rise(values: Float64, low: float, high: float) -> Float64:
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))[:, None]


def _deform_skull(points: Float64, face: FaceShape) -> Float64:
    grown = _rise(points[:, 1], 1.545, 1.625) * (1.0 - 0.85 * _rise(points[:, 2], 0.045, 0.085)) + 0.55 * _rise(
        points[:, 1], 1.61, 1.66
    ) * _rise(points[:, 2], 0.045, 0.085)
    return np.asarray(points + 0.125 * face.skull * np.minimum(grown, 1.0) * (points - _SKULL_CENTRE))


def deform(points: Float64, face: FaceShape) -> Float64:
    """Return points (N, 3) of the usual head [m] as they lie on a face of that shape."""
    p, f = points, face
    side = np.sign(p[:, :1]) * _X
    out = _deform_skull(p, f) - p

    def add(amount: float, direction: Float64, *bump: tuple[float, float, float]) -> None:
        nonlocal out
        if amount:
            out = out + amount * _bump(p, *bump) * direction

    mm = 1e-3
    add(4.2 * mm * f.jaw, side + 0.15 * _Z, (0.050, 1.512, 0.016), (0.030, 0.022, 0.045))
    add(2.0 * mm * f.jaw, side, (0.028, 1.503, 0.066), (0.016, 0.018, 0.030))
    add(4.5 * mm * f.chin, -_Y + 0.45 * _Z, (0.0, 1.494, 0.082), (0.030, 0.020, 0.034))
    add(3.4 * mm * f.cheekbones, side + 0.5 * _Z, (0.056, 1.572, 0.050), (0.022, 0.014, 0.030))
    add(5.0 * mm * f.cheeks, side + 0.55 * _Z, (0.046, 1.540, 0.056), (0.022, 0.026, 0.030))
    add(3.6 * mm * f.brow, _Z - 0.1 * _Y, (0.020, 1.607, 0.088), (0.026, 0.008, 0.020))
    add(6.0 * mm * f.forehead, _Z, (0.0, 1.648, 0.080), (0.050, 0.026, 0.040))
    add(-4.0 * mm * f.nose_length, _Y - 0.55 * _Z, (0.0, 1.556, 0.106), (0.016, 0.015, 0.020))
    add(3.2 * mm * f.nose_width, side, (0.014, 1.554, 0.092), (0.011, 0.013, 0.018))
    add(3.6 * mm * f.nose_bridge, _Z, (0.0, 1.578, 0.099), (0.011, 0.014, 0.020))
    add(3.4 * mm * f.nose_tip, _Y + 0.25 * _Z, (0.0, 1.557, 0.110), (0.011, 0.010, 0.014))
    add(2.2 * mm * f.lips, _Z, (0.0, 1.527, 0.096), (0.024, 0.011, 0.014))
    add(1.5 * mm * f.lips, _Y, (0.006, 1.537, 0.095), (0.018, 0.005, 0.014))
    add(-1.6 * mm * f.lips, _Y, (0.006, 1.519, 0.093), (0.018, 0.006, 0.014))
    add(3.0 * mm * f.mouth, side - 0.3 * _Z, (0.024, 1.5275, 0.082), (0.010, 0.014, 0.018))
    add(2.4 * mm * f.corners, _Y + 0.15 * side, (0.0245, 1.5275, 0.081), (0.0095, 0.009, 0.020))
    add(1.0 * mm * f.corners, _Z + 0.5 * _Y, (0.044, 1.556, 0.062), (0.018, 0.014, 0.024))
    # age: jowls hang, cheeks sink, a fold runs from the nose to the corner of the mouth, the sockets deepen
    add(5.0 * mm * f.age, side - 0.6 * _Y, (0.042, 1.506, 0.050), (0.018, 0.014, 0.026))
    add(-3.6 * mm * f.age, side + 0.8 * _Z, (0.048, 1.548, 0.056), (0.018, 0.016, 0.026))
    add(-2.2 * mm * f.age, _Z, (0.028, 1.540, 0.080), (0.006, 0.014, 0.014))
    add(-2.6 * mm * f.age, _Z + 0.4 * side, (0.054, 1.612, 0.058), (0.016, 0.014, 0.026))
    add(4.0 * mm * max(f.neck, 0.0), _Z, (0.0, 1.462, 0.038), (0.010, 0.011, 0.020))
    add(2.0 * mm * f.neck, side, (0.040, 1.470, 0.000), (0.020, 0.030, 0.040))
    near_eye = np.column_stack([np.abs(p[:, 0]), p[:, 1:]]) - np.array(EYE_CENTRE)
    apart = np.sqrt((near_eye**2).sum(axis=1))
    return np.asarray(p + out * _rise(apart, 0.0135, _EYE_KEPT))


def lowest_point(face: FaceShape) -> float:
    """Return the height of a face's chin [m]."""
    return float(deform(np.array([[0.0, CHIN, 0.078]]), face)[0, 1])
