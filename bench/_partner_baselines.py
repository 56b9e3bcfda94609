"""Followers to compare with: nearest unit without continuity, nearest frame, one who keeps a constant offset, and a
kernel regression."""

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.answer import answer
from live.motion.partner.decoder import Reading
from live.motion.partner.evaluation import facing_of, joint_positions
from live.motion.partner.point_clouds import END_JOINTS, Cloud, fit, time_scaled
from live.motion.partner.units import Units

Float64 = npt.NDArray[np.float64]

FRAME_RATE = 15.0
"""Frames per second at which the nearest frame is looked for; between them its recording goes on."""


def nearest_units(x: Cloud, units: Units, beats: Float64) -> Clip:
    """At every second beat the unit that fits best alone (3), whatever came before; nothing is smoothed."""
    edges = np.unique(np.round(beats[::2] * x.rate).astype(np.int64))
    edges = edges[(edges >= 0) & (edges < x.count)]
    edges = np.unique(np.concatenate(([0], edges[edges > 12], [x.count - 1])))
    rows: list[tuple[int, int, int, complex, complex]] = []
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        window = Cloud(x.floor[begin : end + 1], x.height[begin : end + 1], x.rate)
        thin = window.at(np.linspace(0.0, end - begin, 9))
        fits = []
        for unit in range(units.count):
            of = units.examples[int(units.example[unit])]
            fits.append(fit(thin, time_scaled(of.control, float(units.start[unit]), float(units.length[unit]), 8)))
        best = int(np.argmin([one.distance for one in fits]))
        rows.append((best, begin, end - begin, fits[best].turn, fits[best].shift))
    chosen, start, duration, turn, shift = (np.array(column) for column in zip(*rows, strict=True))
    zeros = np.zeros(len(rows))
    return answer(
        Reading(chosen, start, duration, turn, shift, zeros, zeros[1:], 0.0, x.rate), units, x.count, "none"
    ).clip


def nearest_frames(x: Cloud, units: Units) -> Clip:
    """Each frame alone: the recorded frame at which a leader's hands and feet were nearest, after alignment."""
    examples = units.examples
    step = round(x.rate / FRAME_RATE)
    floor = np.concatenate([one.control.floor[::step] for one in examples])
    height = np.concatenate([one.control.height[::step] for one in examples])
    which = np.concatenate([np.full(len(one.control.floor[::step]), n) for n, one in enumerate(examples)])
    place = np.concatenate([np.arange(len(one.control.floor[::step])) * step for one in examples])
    middle = floor.mean(axis=1)
    centred = floor - middle[:, None]
    size = (np.abs(centred) ** 2).sum(axis=1)
    parts: list[tuple[Float64, Float64, npt.NDArray[np.bool_]]] = []
    for at in range(0, x.count, step):
        own = x.floor[at] - x.floor[at].mean()
        product = (centred.conj() * own).sum(axis=1)
        left = size - 2.0 * np.abs(product) + ((height - x.height[at]) ** 2).sum(axis=1)
        best = int(np.argmin(left))
        turn = complex(product[best] / max(abs(product[best]), 1e-12))
        shift = complex(x.floor[at].mean() - turn * middle[best])
        samples = np.asarray(place[best] + np.arange(min(step, x.count - at)), np.float64)
        parts.append(_moved(examples[int(which[best])].follower, samples, turn, shift))
    root, rotation, contact = (np.concatenate([one[n] for one in parts]) for n in range(3))
    return _clip(root, rotation, contact, x.rate)


def constant_offset(leader: Clip, units: Units, leaders: list[Clip]) -> Clip:
    """The leader's own motion, turned and moved as followers stand to leaders in the mean."""
    places, headings = [], []
    for of, lead in zip(units.examples, leaders, strict=True):
        own, other = _heading(lead), _heading(of.follower)
        apart = (of.follower.root_position - lead.root_position).astype(np.float64)
        places.append((apart[:, 2] + 1j * apart[:, 0]) * own.conj())
        headings.append(other * own.conj())
    place, heading = np.concatenate(places).mean(), np.concatenate(headings).mean()
    heading = heading / abs(heading)
    root = leader.root_position.astype(np.float64)
    at = root[:, 2] + 1j * root[:, 0] + place * _heading(leader)
    half = 0.5 * np.angle(heading)
    rotation = leader.rotation.astype(np.float64).copy()
    rotation[:, 0] = quaternion.mul(np.array((np.cos(half), 0.0, np.sin(half), 0.0)), rotation[:, 0])
    return _clip(np.stack((at.imag, root[:, 1], at.real), axis=1), rotation, leader.contact, leader.sample_rate)


REGRESSION_LAGS = (0.0, 0.5, 1.0)
"""How long ago [s] the leader's points count for the regression."""


def kernel_regression(leader: Clip, units: Units, leaders: list[Clip]) -> tuple[Float64, npt.NDArray[np.complex128]]:
    """The causal regression that a live follower has to beat: joints (T, J, 3) and facing from the leader's hands, feet
    and hips now and a while ago, in the frame of his hips; a Gaussian kernel and a ridge, learnt at 15 Hz."""
    inputs, outputs = [], []
    for lead, of in zip(leaders, units.examples, strict=True):
        points, middle, front = _regression_input(lead)
        own = _seen_from(joint_positions(of.follower), middle, front)
        turned = facing_of(of.follower) * front.conj()
        inputs.append(points[::4])
        outputs.append(np.column_stack((own.reshape(len(own), -1), turned.real, turned.imag))[::4])
    known, wanted = np.concatenate(inputs), np.concatenate(outputs)
    points, middle, front = _regression_input(leader)
    centre, spread, mean = known.mean(axis=0), known.std(axis=0).mean(), wanted.mean(axis=0)
    known, points = (known - centre) / spread, (points - centre) / spread
    width = 2.0 * 0.5**2 * known.shape[1]

    def kernel(one: Float64, other: Float64) -> Float64:
        square = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1) - 2.0 * one @ other.T
        return np.asarray(np.exp(-np.maximum(square, 0.0) / width))

    weights = np.linalg.solve(kernel(known, known) + 0.2 * np.eye(len(known)), wanted - mean)
    made = kernel(points, known) @ weights + mean
    joints = made[:, :-2].reshape(len(made), -1, 3)
    place = (joints[..., 2] + 1j * joints[..., 0]) * front[:, None] + middle[:, None]
    facing = (made[:, -2] + 1j * made[:, -1]) * front
    return np.stack((place.imag, joints[..., 1], place.real), axis=-1), facing / np.maximum(np.abs(facing), 1e-9)


def _regression_input(leader: Clip) -> tuple[Float64, npt.NDArray[np.complex128], npt.NDArray[np.complex128]]:
    joints = joint_positions(leader)
    points, front = joints[:, (0, *END_JOINTS)], facing_of(leader)
    middle = joints[:, 0, 2] + 1j * joints[:, 0, 0]
    rows = np.arange(len(points))
    past = [np.maximum(rows - round(lag * leader.sample_rate), 0) for lag in REGRESSION_LAGS]
    parts = [_seen_from(points[at], middle, front).reshape(len(points), -1) for at in past]
    return np.concatenate(parts, axis=1), middle, front


def _seen_from(points: Float64, middle: npt.NDArray[np.complex128], front: npt.NDArray[np.complex128]) -> Float64:
    """Points (T, P, 3) in the frame of hips."""
    place = (points[..., 2] + 1j * points[..., 0] - middle[:, None]) * front.conj()[:, None]
    return np.stack((place.imag, points[..., 1], place.real), axis=-1)


def _heading(clip: Clip) -> npt.NDArray[np.complex128]:
    """Where the hips face, smoothed over half a second, as unit numbers, (T,)."""
    _, rotation = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    front = quaternion.rotate(rotation[:, 0], np.array((0.0, 0.0, 1.0)))
    number = front[:, 2] + 1j * front[:, 0]
    kernel = np.ones(31) / 31.0
    smooth = np.convolve(np.pad(number, 15, mode="edge"), kernel, mode="valid")
    return np.asarray(smooth / np.maximum(np.abs(smooth), 1e-9))


def _moved(
    clip: Clip, samples: Float64, turn: complex, shift: complex
) -> tuple[Float64, Float64, npt.NDArray[np.bool_]]:
    root, rotation, contact = read_clip(clip, samples)
    place = turn * (root[:, 2] + 1j * root[:, 0]) + shift
    half = 0.5 * np.angle(turn)
    rotation[:, 0] = quaternion.mul(np.array((np.cos(half), 0.0, np.sin(half), 0.0)), rotation[:, 0])
    return np.stack((place.imag, root[:, 1], place.real), axis=1), np.asarray(rotation, np.float64), contact


def _clip(root: Float64, rotation: Float64, contact: npt.NDArray[np.bool_], rate: float) -> Clip:
    return Clip(
        "baseline", np.ascontiguousarray(root, np.float32),
        np.ascontiguousarray(quaternion.unit(rotation), np.float32), rate, np.ascontiguousarray(contact),
    )  # fmt: skip
