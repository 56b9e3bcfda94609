"""BVH files for tests: a body whose size, axes, rest pose and motion the test chooses."""

import numpy as np

# name, parent, offset [cm] with the arms out and +z ahead
BODY = (
    ("Hips", "", (0.0, 0.0, 0.0)),
    ("Spine", "Hips", (0.0, 12.0, 0.0)),
    ("Spine1", "Spine", (0.0, 14.0, 0.0)),
    ("Neck", "Spine1", (0.0, 24.0, 0.0)),
    ("Head", "Neck", (0.0, 9.0, 0.0)),
    ("LeftShoulder", "Spine1", (3.0, 20.0, 0.0)),
    ("LeftArm", "LeftShoulder", (14.0, 0.0, 0.0)),
    ("LeftForeArm", "LeftArm", (27.0, 0.0, 0.0)),
    ("LeftHand", "LeftForeArm", (24.0, 0.0, 0.0)),
    ("RightShoulder", "Spine1", (-3.0, 20.0, 0.0)),
    ("RightArm", "RightShoulder", (-14.0, 0.0, 0.0)),
    ("RightForeArm", "RightArm", (-27.0, 0.0, 0.0)),
    ("RightHand", "RightForeArm", (-24.0, 0.0, 0.0)),
    ("LeftUpLeg", "Hips", (9.0, -4.0, 0.0)),
    ("LeftLeg", "LeftUpLeg", (0.0, -42.0, 0.0)),
    ("LeftFoot", "LeftLeg", (0.0, -40.0, 0.0)),
    ("LeftToeBase", "LeftFoot", (0.0, -6.0, 13.0)),
    ("RightUpLeg", "Hips", (-9.0, -4.0, 0.0)),
    ("RightLeg", "RightUpLeg", (0.0, -42.0, 0.0)),
    ("RightFoot", "RightLeg", (0.0, -40.0, 0.0)),
    ("RightToeBase", "RightFoot", (0.0, -6.0, 13.0)),
)
NAMES = tuple(name for name, _, _ in BODY)
STANDING_CM = 94.0
"""Height of the hips over the floor when the body of BODY stands straight."""


def body_bvh(
    values: np.ndarray,
    *,
    fps: float = 60.0,
    scale: float = 1.0,
    z_up: bool = False,
    offsets: dict[str, tuple[float, float, float]] | None = None,
    declared: int | None = None,
) -> str:
    """A BVH text of BODY; `values` (T, 3 + 3 * 21): hips position [cm], then Z, X, Y rotations [degrees] per joint.

    `scale` is the file's units per centimeter. `z_up` writes the same motion with Z up and -Y ahead: position
    (x, y, z) → (x, -z, y), and each rotation about an axis becomes that about the axis it maps to.
    """

    def place(x: float, y: float, z: float) -> tuple[float, float, float]:
        return (x * scale, -z * scale, y * scale) if z_up else (x * scale, y * scale, z * scale)

    values = np.array(values, np.float64)
    moved = values[:, :3] * scale
    if z_up:
        moved = np.stack((moved[:, 0], -moved[:, 2], moved[:, 1]), axis=1)
        values[:, 5::3] *= -1.0  # about y becomes about +z, about z about -y; written in the order Y X Z
        values[:, 3::3], values[:, 5::3] = -values[:, 3::3], -values[:, 5::3]
    values[:, :3] = moved
    order = "Yrotation Xrotation Zrotation" if z_up else "Zrotation Xrotation Yrotation"
    children: dict[str, list[str]] = {name: [] for name in NAMES}
    for name, parent, _ in BODY:
        if parent:
            children[parent].append(name)
    own = {name: (offsets or {}).get(name, offset) for name, _, offset in BODY}
    lines = ["HIERARCHY"]

    def write(name: str, depth: int) -> None:
        tab = "\t" * depth
        lines.append(f"{tab}{'ROOT' if depth == 0 else 'JOINT'} {name}")
        lines.append(tab + "{")
        lines.append(f"{tab}\tOFFSET " + " ".join(f"{v:.6f}" for v in place(*own[name])))
        root = "6 Xposition Yposition Zposition " if depth == 0 else "3 "
        lines.append(f"{tab}\tCHANNELS {root}{order}")
        for child in children[name]:
            write(child, depth + 1)
        if not children[name]:
            lines.append(f"{tab}\tEnd Site")
            lines.append(tab + "\t{")
            lines.append(f"{tab}\t\tOFFSET " + " ".join(f"{0.3 * v:.6f}" for v in place(*own[name])))
            lines.append(tab + "\t}")
        lines.append(tab + "}")

    write("Hips", 0)
    lines += ["MOTION", f"Frames: {len(values) if declared is None else declared}", f"Frame Time: {1.0 / fps:.9f}"]
    lines += [" ".join(f"{value:.9g}" for value in row) for row in values]
    return "\n".join(lines) + "\n"


def still(frames: int = 1) -> np.ndarray:
    """Values of a body that stands in its rest pose, shape (frames, 66)."""
    values = np.zeros((frames, 3 + 3 * len(NAMES)))
    values[:, 1] = STANDING_CM
    return values


def column(joint: str, axis: str) -> int:
    """Column of a joint's rotation about an axis in the values."""
    return 3 + 3 * NAMES.index(joint) + "ZXY".index(axis)


def dance_values(frames: int = 240, seed: int = 5) -> np.ndarray:
    """Values of a body that turns, travels and moves every joint smoothly, shape (frames, 66)."""
    rng = np.random.default_rng(seed)
    values = still(frames)
    beat = np.linspace(0.0, 4.0 * np.pi, frames)
    for joint in NAMES:
        for axis in "ZXY":
            swing = 20.0 if joint in ("Hips", "Spine", "Spine1", "Neck", "Head") else 35.0
            values[:, column(joint, axis)] += swing * rng.uniform(-1, 1) * np.sin(beat * rng.integers(1, 3))
    for side in ("Left", "Right"):
        values[:, column(side + "Leg", "X")] = 30.0 + 25.0 * np.sin(beat)
        values[:, column(side + "ForeArm", "Y")] = (-50.0 if side == "Left" else 50.0) + 20.0 * np.sin(beat)
    values[:, column("Hips", "Y")] += np.linspace(0.0, 200.0, frames)
    values[:, 0] = np.linspace(0.0, 150.0, frames)
    values[:, 2] = 40.0 * np.sin(beat)
    return values
