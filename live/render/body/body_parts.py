"""Parts of the dancer's body in the rest pose [m], for a dancer 1.7 m tall (eight heads), left half (+x).

Lofts follow the bones of `live.motion.skeleton`. What light shows of bones and muscles is small parts on them: collar
bones, ribs, shoulder blades, knee caps, ankles.
"""

from dataclasses import replace
from typing import Final

from live.render.body.hand_parts import HAND
from live.render.body.implicit_surface import Ellipsoid, Loft, upright

Part = Loft | Ellipsoid

TORSO: Final = upright(
    0.0,
    0.0,
    (
        (1.415, 0.070, 0.036, 0.050, -0.018),
        (1.380, 0.122, 0.058, 0.070, -0.014),
        (1.330, 0.140, 0.083, 0.086, -0.008),
        (1.270, 0.138, 0.096, 0.090, -0.004),
        (1.200, 0.128, 0.093, 0.085, 0.000),
        (1.120, 0.113, 0.083, 0.074, 0.004),
        (1.060, 0.108, 0.079, 0.070, 0.006),
        (1.000, 0.117, 0.081, 0.076, 0.005),
        (0.940, 0.135, 0.085, 0.090, 0.002),
        (0.890, 0.146, 0.083, 0.098, 0.000),
        (0.850, 0.140, 0.074, 0.092, 0.000),
        (0.815, 0.100, 0.052, 0.068, 0.000),
    ),
    0.0,
)
NECK: Final = upright(
    0.0,
    0.0,
    (
        (1.540, 0.042, 0.042, 0.046, 0.000),
        (1.480, 0.041, 0.041, 0.046, -0.005),
        (1.420, 0.047, 0.045, 0.052, -0.014),
        (1.380, 0.060, 0.046, 0.056, -0.022),
    ),
    0.045,
)
LEG: Final = upright(
    0.09,
    0.0,
    (
        (0.920, 0.062, 0.066, 0.070, 0.0),
        (0.860, 0.075, 0.078, 0.084, 0.0),
        (0.790, 0.077, 0.084, 0.086, 0.0),
        (0.710, 0.070, 0.082, 0.077, 0.0),
        (0.620, 0.060, 0.071, 0.066, 0.0),
        (0.540, 0.050, 0.058, 0.055, 0.0),
        (0.495, 0.047, 0.053, 0.050, 0.0),
        (0.465, 0.046, 0.051, 0.049, 0.0),
        (0.425, 0.045, 0.044, 0.054, 0.0),
        (0.365, 0.048, 0.040, 0.066, 0.0),
        (0.305, 0.045, 0.038, 0.062, 0.0),
        (0.225, 0.034, 0.034, 0.044, 0.0),
        (0.150, 0.027, 0.030, 0.033, 0.0),
        (0.100, 0.0265, 0.030, 0.034, 0.0),
        (0.055, 0.027, 0.030, 0.036, 0.0),
    ),
    0.040,
)
_VERTICAL: Final = (0.0, 1.0, 0.0)
ARM: Final = Loft(
    (0.130, 1.378, -0.010),
    (0.690, 1.380, -0.010),
    _VERTICAL,
    (
        (0.000, 0.040, 0.042, 0.042, 0.0),
        (0.100, 0.041, 0.042, 0.042, 0.0),
        (0.220, 0.040, 0.042, 0.043, 0.0),
        (0.350, 0.038, 0.039, 0.039, 0.0),
        (0.470, 0.032, 0.034, 0.034, 0.0),
        (0.536, 0.031, 0.033, 0.034, 0.0),
        (0.610, 0.034, 0.037, 0.036, 0.0),
        (0.740, 0.030, 0.033, 0.032, 0.0),
        (0.880, 0.021, 0.025, 0.024, 0.0),
        (1.000, 0.018, 0.025, 0.024, 0.0),
    ),
    0.050,
)
FOOT: Final = Loft(
    (0.090, 0.052, 0.000),
    (0.092, 0.022, 0.130),
    (1.0, 0.0, 0.0),
    (
        (0.00, 0.027, 0.036, 0.046, 0.0),
        (0.40, 0.034, 0.034, 0.038, 0.0),
        (0.80, 0.042, 0.023, 0.028, 0.0),
        (1.00, 0.043, 0.018, 0.022, 0.0),
    ),
    0.030,
)
TOES: Final = Loft(
    (0.092, 0.020, 0.128),
    (0.088, 0.010, 0.174),
    (1.0, 0.0, 0.0),
    (
        (0.0, 0.042, 0.017, 0.020, 0.0),
        (0.3, 0.041, 0.0145, 0.017, 0.0),
        (0.6, 0.036, 0.0095, 0.013, 0.0),
        (1.0, 0.024, 0.006, 0.010, 0.0),
    ),
    0.012,
)

CHEST: Final = Ellipsoid((0.060, 1.250, 0.058), (0.064, 0.058, 0.048), 0.050)
SEAT: Final = Ellipsoid((0.072, 0.872, -0.058), (0.078, 0.084, 0.062), 0.040)
DELTOID: Final = Ellipsoid((0.166, 1.375, -0.010), (0.047, 0.040, 0.045), 0.045)
HEEL: Final = Ellipsoid((0.090, 0.034, -0.027), (0.028, 0.036, 0.037), 0.022)
ARMPIT: Final = Ellipsoid((0.172, 1.308, -0.012), (0.028, 0.030, 0.030), 0.030, hollow=True)
TRAPEZIUS: Final = Loft(
    (0.020, 1.440, -0.026),
    (0.142, 1.392, -0.014),
    _VERTICAL,
    ((0.0, 0.032, 0.032, 0.032, 0.0), (1.0, 0.024, 0.030, 0.032, 0.0)),
    0.045,
)
CROTCH: Final = Ellipsoid((0.0, 0.842, 0.006), (0.075, 0.040, 0.062), 0.040)


def _rod(start: tuple[float, float, float], end: tuple[float, float, float], radius: float, blend: float) -> Loft:
    rows = ((0.0, radius, radius, radius, 0.0), (1.0, radius, radius, radius, 0.0))
    return Loft(start, end, (0.3, 0.9, 0.31), rows, blend)


COLLAR: Final = Loft(
    (0.014, 1.403, 0.022),
    (0.138, 1.404, 0.002),
    _VERTICAL,
    ((0.0, 0.0070, 0.0075, 0.0075, 0.0), (0.4, 0.0060, 0.0065, 0.0065, 0.008), (1.0, 0.0070, 0.0070, 0.0070, 0.0)),
    0.026,
)
"""The collar bone, an S seen from above."""
NAVEL: Final = Ellipsoid((0.0, 1.030, 0.0905), (0.0065, 0.0090, 0.0085), 0.010, hollow=True)
TORSO_DETAILS: Final[tuple[Part, ...]] = (
    Ellipsoid((0.062, 1.345, 0.050), (0.060, 0.050, 0.024), 0.030),  # upper part of the chest's muscle
    Ellipsoid((0.098, 1.240, -0.040), (0.032, 0.100, 0.036), 0.045),  # the broad back under the arm
    Ellipsoid((0.082, 1.300, -0.076), (0.034, 0.056, 0.015), 0.016, 0.0, 10.0),  # shoulder blade
    Ellipsoid((0.030, 1.080, -0.050), (0.022, 0.120, 0.020), 0.030),  # straight muscle of the back
    Ellipsoid((0.104, 0.968, 0.042), (0.018, 0.030, 0.020), 0.028),  # crest of the hip bone
    Ellipsoid((0.0, 1.282, 0.112), (0.010, 0.075, 0.015), 0.030, hollow=True),  # breast bone
    replace(
        upright(
            0.0,
            0.0,
            tuple(
                (y, 0.011, 0.010, 0.010, z)
                for y, z in (
                    (1.340, -0.110),
                    (1.270, -0.101),
                    (1.200, -0.090),
                    (1.120, -0.074),
                    (1.060, -0.068),
                    (1.000, -0.076),
                    (0.950, -0.100),
                )
            ),
            0.020,
        ),
        hollow=True,
    ),  # furrow of the spine
)
ARM_DETAILS: Final[tuple[Part, ...]] = (
    Ellipsoid((0.300, 1.382, 0.008), (0.070, 0.024, 0.024), 0.022),  # biceps
    Ellipsoid((0.285, 1.378, -0.032), (0.075, 0.026, 0.020), 0.024),  # triceps
    Ellipsoid((0.222, 1.380, -0.010), (0.032, 0.034, 0.032), 0.030),  # tip of the deltoid
    Ellipsoid((0.434, 1.380, -0.038), (0.013, 0.010, 0.009), 0.012),  # point of the elbow
    Ellipsoid((0.490, 1.392, 0.008), (0.055, 0.018, 0.020), 0.020),  # muscle of the lower arm
    Ellipsoid((0.662, 1.394, -0.028), (0.009, 0.007, 0.007), 0.008),  # head of the ulna
)
LEG_DETAILS: Final[tuple[Part, ...]] = (
    Ellipsoid((0.112, 0.640, 0.040), (0.028, 0.090, 0.028), 0.026),  # outer head of the thigh's muscle
    Ellipsoid((0.070, 0.560, 0.038), (0.022, 0.052, 0.024), 0.020),  # inner one, above the knee
    Ellipsoid((0.090, 0.486, 0.043), (0.020, 0.025, 0.013), 0.012),  # knee cap
    _rod((0.090, 0.460, 0.045), (0.090, 0.428, 0.037), 0.008, 0.012),  # its sinew
    Ellipsoid((0.073, 0.350, -0.042), (0.026, 0.068, 0.030), 0.020),  # inner calf
    Ellipsoid((0.106, 0.366, -0.038), (0.024, 0.062, 0.028), 0.020),  # outer calf
    _rod((0.086, 0.400, 0.036), (0.085, 0.200, 0.018), 0.009, 0.020),  # shin
    Ellipsoid((0.072, 0.108, -0.030), (0.0075, 0.036, 0.009), 0.014, hollow=True),  # beside the Achilles sinew
    Ellipsoid((0.109, 0.104, -0.032), (0.0075, 0.036, 0.009), 0.014, hollow=True),
    Ellipsoid((0.065, 0.090, 0.004), (0.009, 0.013, 0.013), 0.010),  # inner ankle
    Ellipsoid((0.117, 0.078, -0.006), (0.008, 0.013, 0.012), 0.010),  # outer ankle
)
FOOT_DETAILS: Final[tuple[Part, ...]] = (
    Ellipsoid((0.056, 0.022, 0.124), (0.012, 0.017, 0.020), 0.014),  # ball of the big toe
    Ellipsoid((0.126, 0.016, 0.100), (0.010, 0.014, 0.030), 0.014),  # outer edge
    Ellipsoid((0.060, -0.004, 0.052), (0.022, 0.020, 0.042), 0.014, hollow=True),  # arch
)

TOES_TOGETHER: Final = Loft(
    (0.092, 0.018, 0.128),
    (0.085, 0.011, 0.184),
    (1.0, 0.0, 0.0),
    ((0.0, 0.040, 0.016, 0.020, 0.0), (0.6, 0.036, 0.012, 0.014, 0.0), (1.0, 0.022, 0.008, 0.010, 0.0)),
    0.010,
)
"""Around the toes, for bodies that are drawn without them."""

TOE_PARTS: Final[tuple[Loft, ...]] = tuple(
    Loft(
        (x, 0.0135 * size, 0.138 - back), (x + lean, 0.0105 * size, 0.184 - back - short), (1.0, 0.0, 0.0),
        ((0.0, 0.0085 * size, 0.0090 * size, 0.010, 0.0), (0.55, 0.0085 * size, 0.0080 * size, 0.010, 0.0),
         (0.8, 0.0098 * size, 0.0095 * size, 0.010, 0.0), (1.0, 0.0080 * size, 0.0070 * size, 0.008, 0.0)),
        0.004,
    )
    for x, lean, back, short, size in (
        (0.0625, 0.002, 0.0, 0.000, 1.30), (0.0830, 0.001, 0.0, 0.002, 0.92), (0.0985, -0.001, 0.003, 0.007, 0.88),
        (0.1125, -0.003, 0.007, 0.013, 0.85), (0.1250, -0.006, 0.013, 0.018, 0.85),
    )
)  # fmt: skip
"""The toes, the big one first."""

BODY: Final[tuple[Part, ...]] = (
    TORSO,
    CHEST,
    SEAT,
    NECK,
    TRAPEZIUS,
    *TORSO_DETAILS,
    NAVEL,
    COLLAR,
    DELTOID,
    ARM,
    ARMPIT,
    *ARM_DETAILS,
    *HAND,
    LEG,
    CROTCH,
    *LEG_DETAILS,
    HEEL,
    FOOT,
    TOES,
    *FOOT_DETAILS,
    # a head for far away (near ones are meshes of their own): skull, face, chin, nose
    Ellipsoid((0.0, 1.622, -0.006), (0.0735, 0.078, 0.0935), 0.015),
    Ellipsoid((0.0, 1.570, 0.030), (0.054, 0.074, 0.056), 0.035),
    Ellipsoid((0.0, 1.507, 0.058), (0.028, 0.020, 0.028), 0.035),
    Ellipsoid((0.0, 1.572, 0.088), (0.009, 0.024, 0.014), 0.020, 14.0),
)
"""The left half of the body, in blending order."""
