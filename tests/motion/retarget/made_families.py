"""Bodies with the joint names and hierarchies of character makers and capture programs, posed independently.

Each family is a tree in text, a joint a line: its name, and the engine's joint at whose place it is. `joint:share` lies
on the way to the engine's next joint. The names are those that the makers document; offsets and motion are made here.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from live.motion.formats.source_motion import SourceMotion
from live.motion.skeleton import BONE_TIPS, SKELETON

NEXT = {parent: child for child, parent in reversed(list(enumerate(SKELETON.parents.tolist())))}
"""A child of each joint."""


def limbs(text: str) -> str:
    """The text twice, with {S} as Left and Right, {s} as left and right, {L} as L and R, {l} as l and r."""
    sides = (("Left", "left", "L", "l"), ("Right", "right", "R", "r"))
    return "".join(text.format(S=one, s=two, L=three, l=four) for one, two, three, four in sides)


REALLUSION = (
    "RL_BoneRoot floor\n CC_Base_Hip hips\n  CC_Base_Pelvis hips\n"
    + limbs(
        "   CC_Base_{L}_Thigh {s}UpperLeg\n    CC_Base_{L}_ThighTwist01 {s}UpperLeg:0.3\n"
        "    CC_Base_{L}_ThighTwist02 {s}UpperLeg:0.7\n    CC_Base_{L}_Calf {s}LowerLeg\n"
        "     CC_Base_{L}_CalfTwist01 {s}LowerLeg:0.4\n     CC_Base_{L}_KneeShareBone {s}LowerLeg\n"
        "     CC_Base_{L}_Foot {s}Foot\n      CC_Base_{L}_ToeBaseShareBone {s}Toes\n      CC_Base_{L}_ToeBase {s}Toes\n"
        "       CC_Base_{L}_BigToe1 {s}Toes:0.5\n"
    )
    + "  CC_Base_Waist spine\n   CC_Base_Spine01 chest\n    CC_Base_Spine02 upperChest\n"
    "     CC_Base_NeckTwist01 neck\n      CC_Base_NeckTwist02 neck:0.5\n       CC_Base_Head head\n"
    "        CC_Base_JawRoot head:0.1\n"
    + limbs(
        "     CC_Base_{L}_Clavicle {s}Shoulder\n      CC_Base_{L}_Upperarm {s}UpperArm\n"
        "       CC_Base_{L}_UpperarmTwist01 {s}UpperArm:0.3\n       CC_Base_{L}_Forearm {s}LowerArm\n"
        "        CC_Base_{L}_ForearmTwist01 {s}LowerArm:0.5\n        CC_Base_{L}_Hand {s}Hand\n"
        "         CC_Base_{L}_Mid1 {s}Hand:0.5\n          CC_Base_{L}_Mid2 {s}Hand:0.7\n"
    )
)
"""Character Creator and iClone (Reallusion); AccuRig."""

MIXAMO = (
    "{p}Hips hips\n {p}Spine spine\n  {p}Spine1 chest\n   {p}Spine2 upperChest\n    {p}Neck neck\n     {p}Head head\n"
    "      {p}HeadTop_End head:1\n"
    + limbs(
        "    {{p}}{S}Shoulder {s}Shoulder\n     {{p}}{S}Arm {s}UpperArm\n      {{p}}{S}ForeArm {s}LowerArm\n"
        "       {{p}}{S}Hand {s}Hand\n        {{p}}{S}HandMiddle1 {s}Hand:0.5\n"
    )
    + limbs(
        " {{p}}{S}UpLeg {s}UpperLeg\n  {{p}}{S}Leg {s}LowerLeg\n   {{p}}{S}Foot {s}Foot\n    {{p}}{S}ToeBase {s}Toes\n"
        "     {{p}}{S}Toe_End {s}Toes:1\n"
    )
)
"""Mixamo, and Perception Neuron and Axis Studio (Noitom) with other prefixes."""

ROKOKO = (
    "Hips hips\n Spine1 spine\n  Spine2 spine:0.5\n   Spine3 chest\n    Spine4 upperChest\n"
    "     Neck neck\n      Head head\n"
    + limbs(
        "     {S}Shoulder {s}Shoulder\n      {S}Arm {s}UpperArm\n       {S}ForeArm {s}LowerArm\n"
        "        {S}Hand {s}Hand\n"
        "         {S}Finger1Proximal {s}Hand:0.5\n"
    )
    + limbs(" {S}Thigh {s}UpperLeg\n  {S}Shin {s}LowerLeg\n   {S}Foot {s}Foot\n    {S}Toe {s}Toes\n")
)
"""Rokoko Studio."""

XSENS_BVH = (
    "Hips hips\n Chest spine\n  Chest2 chest\n   Chest3 chest:0.5\n    Chest4 upperChest\n"
    "     Neck neck\n      Head head\n"
    + limbs(
        "     {S}Collar {s}Shoulder\n      {S}Shoulder {s}UpperArm\n       {S}Elbow {s}LowerArm\n"
        "        {S}Wrist {s}Hand\n"
    )
    + limbs(" {S}Hip {s}UpperLeg\n  {S}Knee {s}LowerLeg\n   {S}Ankle {s}Foot\n    {S}Toe {s}Toes\n")
)
"""Xsens MVN, its BVH."""

XSENS_SEGMENTS = (
    "Pelvis hips\n L5 spine\n  L3 chest\n   T12 chest:0.5\n    T8 upperChest\n     Neck neck\n      Head head\n"
    + limbs(
        "     {S}Shoulder {s}Shoulder\n      {S}UpperArm {s}UpperArm\n"
        "       {S}ForeArm {s}LowerArm\n        {S}Hand {s}Hand\n"
    )
    + limbs(" {S}UpperLeg {s}UpperLeg\n  {S}LowerLeg {s}LowerLeg\n   {S}Foot {s}Foot\n    {S}Toe {s}Toes\n")
)
"""Xsens MVN, its segments."""

XSENS_JOINTS = (
    "pHipOrigin hips\n jL5S1 spine\n  jL4L3 chest\n   jL1T12 chest:0.5\n    jT9T8 upperChest\n     jT1C7 neck\n"
    "      jC1Head head\n"
    + limbs(
        "     j{S}T4Shoulder {s}Shoulder\n      j{S}Shoulder {s}UpperArm\n       j{S}Elbow {s}LowerArm\n"
        "        j{S}Wrist {s}Hand\n"
    )
    + limbs(" j{S}Hip {s}UpperLeg\n  j{S}Knee {s}LowerLeg\n   j{S}Ankle {s}Foot\n    j{S}BallFoot {s}Toes\n")
)
"""Xsens MVN, its joints."""

MOTIVE = (
    "{p}Hip hips\n {p}Ab spine\n  {p}Chest upperChest\n   {p}Neck neck\n    {p}Head head\n"
    + limbs(
        "   {{p}}{L}Shoulder {s}Shoulder\n    {{p}}{L}UArm {s}UpperArm\n     {{p}}{L}FArm {s}LowerArm\n"
        "      {{p}}{L}Hand {s}Hand\n"
    )
    + limbs(
        " {{p}}{L}Thigh {s}UpperLeg\n  {{p}}{L}Shin {s}LowerLeg\n   {{p}}{L}Foot {s}Foot\n    {{p}}{L}Toe {s}Toes\n"
    )
)
"""OptiTrack Motive; with the skeleton's name in front of each bone."""

SMPL = (
    "Pelvis hips\n"
    + limbs(" {L}_Hip {s}UpperLeg\n  {L}_Knee {s}LowerLeg\n   {L}_Ankle {s}Foot\n    {L}_Foot {s}Toes\n")
    + " Spine1 spine\n  Spine2 chest\n   Spine3 upperChest\n    Neck neck\n     Head head\n"
    + limbs(
        "    {L}_Collar {s}Shoulder\n     {L}_Shoulder {s}UpperArm\n      {L}_Elbow {s}LowerArm\n"
        "       {L}_Wrist {s}Hand\n"
        "        {L}_Hand {s}Hand:0.5\n"
    )
)
"""SMPL."""

SMPLX = (
    "pelvis hips\n"
    + limbs(" {s}_hip {s}UpperLeg\n  {s}_knee {s}LowerLeg\n   {s}_ankle {s}Foot\n    {s}_foot {s}Toes\n")
    + " spine1 spine\n  spine2 chest\n   spine3 upperChest\n    neck neck\n     head head\n      jaw head:0.1\n"
    "      left_eye_smplhf head:0.4\n      right_eye_smplhf head:0.4\n"
    + limbs(
        "    {s}_collar {s}Shoulder\n     {s}_shoulder {s}UpperArm\n      {s}_elbow {s}LowerArm\n"
        "       {s}_wrist {s}Hand\n"
        "        {s}_index1 {s}Hand:0.5\n         {s}_index2 {s}Hand:0.7\n        {s}_thumb1 {s}Hand:0.2\n"
    )
)
"""SMPL-X."""

DAZ = (
    "hip hips\n pelvis hips\n"
    + limbs(
        "  {l}ThighBend {s}UpperLeg\n   {l}ThighTwist {s}UpperLeg:0.5\n    {l}Shin {s}LowerLeg\n     {l}Foot {s}Foot\n"
        "      {l}Metatarsals {s}Foot:0.5\n       {l}Toe {s}Toes\n"
    )
    + " abdomenLower spine\n  abdomenUpper chest\n   chestLower chest:0.5\n"
    "    chestUpper upperChest\n     neckLower neck\n"
    "      neckUpper neck:0.5\n       head head\n"
    + limbs(
        "     {l}Collar {s}Shoulder\n      {l}ShldrBend {s}UpperArm\n       {l}ShldrTwist {s}UpperArm:0.5\n"
        "        {l}ForearmBend {s}LowerArm\n         {l}ForearmTwist {s}LowerArm:0.5\n          {l}Hand {s}Hand\n"
    )
)
"""Daz Genesis 8."""

UNREAL = (
    "root floor\n pelvis hips\n  spine_01 spine\n   spine_02 chest\n    spine_03 upperChest\n"
    "     neck_01 neck\n      head head\n"
    + limbs(
        "     clavicle_{l} {s}Shoulder\n      upperarm_{l} {s}UpperArm\n       upperarm_twist_01_{l} {s}UpperArm:0.5\n"
        "       lowerarm_{l} {s}LowerArm\n        hand_{l} {s}Hand\n         middle_01_{l} {s}Hand:0.5\n"
    )
    + limbs(
        "  thigh_{l} {s}UpperLeg\n   thigh_twist_01_{l} {s}UpperLeg:0.5\n   calf_{l} {s}LowerLeg\n"
        "    foot_{l} {s}Foot\n"
        "     ball_{l} {s}Toes\n"
    )
)
"""Unreal mannequin."""

FAMILIES = {
    "Reallusion": REALLUSION,
    "iClone without a prefix": REALLUSION.replace("CC_Base_", ""),
    "Mixamo": MIXAMO.replace("{p}", "mixamorig:"),
    "Mixamo in glTF": MIXAMO.replace("{p}", "mixamorig"),
    "Mixamo, numbered": MIXAMO.replace("{p}", "mixamorig1_"),
    "Perception Neuron": MIXAMO.replace("{p}", "Robot_"),
    "Axis Studio": MIXAMO.replace("{p}", ""),
    "Maya HumanIK": MIXAMO.replace("{p}", "Character1_"),
    "Rokoko": ROKOKO,
    "Xsens BVH": XSENS_BVH,
    "Xsens segments": XSENS_SEGMENTS,
    "Xsens joints": XSENS_JOINTS,
    "Motive": MOTIVE.replace("{p}", ""),
    "Motive with a name": MOTIVE.replace("{p}", "Jane_"),
    "SMPL": SMPL,
    "SMPL in FBX": "\n".join(
        " " * (len(line) - len(line.lstrip())) + "m_avg_" + line.lstrip() for line in SMPL.splitlines()
    ),
    "SMPL-X": SMPLX,
    "Daz": DAZ,
    "Unreal": UNREAL,
}


def joints_of(text: str) -> list[tuple[str, int, str, float]]:
    """Name, parent (-1: none), the engine's joint or "floor", and the share of the way to the next, parents first."""
    rows: list[tuple[str, int, str, float]] = []
    above: list[int] = []
    for line in text.splitlines():
        depth = len(line) - len(line.lstrip())
        name, place = line.split()
        joint, _, share = place.partition(":")
        del above[depth:]
        rows.append((name, above[-1] if above else -1, joint, float(share or 0.0)))
        above.append(len(rows) - 1)
    return rows


def danced_angles(frames: int, seed: int = 4) -> dict[str, Rotation]:
    """Local rotations of the engine's joints in a made dance: knees and elbows bend, hips turn; the trunk is stiff."""
    random = np.random.default_rng(seed)
    time = np.arange(frames) / frames

    def wave(size: float, middle: float = 0.0) -> np.ndarray:
        turns, start = random.uniform(1.0, 3.0), random.uniform(0.0, 6.0)
        return middle + size * np.sin(2 * np.pi * turns * time + start)

    def turned(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Rotation:
        return Rotation.from_euler("YXZ", np.stack((y, x, z), axis=1))

    still = np.zeros(frames)
    angles = {name: turned(still, still, still) for name in SKELETON.names}
    angles["hips"] = turned(wave(0.15), wave(1.5), wave(0.1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        angles[f"{side}UpperLeg"] = turned(wave(0.4, -0.3), wave(0.2), sign * wave(0.1, 0.1))
        angles[f"{side}LowerLeg"] = turned(wave(0.4, 0.6), still, still)
        angles[f"{side}Foot"] = turned(wave(0.2), still, still)
        angles[f"{side}UpperArm"] = turned(wave(0.3), sign * wave(0.3, -0.2), sign * wave(0.4, -0.6))
        angles[f"{side}LowerArm"] = turned(still, sign * wave(0.4, -0.8), still)
        angles[f"{side}Hand"] = turned(still, still, wave(0.2))
    return angles


def engine_pose(angles: dict[str, Rotation], frames: int) -> tuple[np.ndarray, list[Rotation]]:
    """World positions (T, 22, 3) [m] and rotations of the engine's joints, by scipy; the hips travel."""
    places = np.zeros((frames, len(SKELETON.names), 3))
    turns: list[Rotation] = []
    for joint, name in enumerate(SKELETON.names):
        parent = int(SKELETON.parents[joint])
        if parent < 0:
            places[:, joint] = SKELETON.offsets[joint] + np.linspace((0.0, 0.0, 0.0), (1.0, 0.0, 0.5), frames)
            turns.append(angles[name])
        else:
            places[:, joint] = places[:, parent] + turns[parent].apply(SKELETON.offsets[joint].astype(np.float64))
            turns.append(turns[parent] * angles[name])
    return places, turns


REST_POSES = {"T": 0.0, "A": 0.7, "hanging": 1.45}
"""How far the arms hang in the rest pose [rad]."""


def family_motion(
    text: str, *, rest: str = "T", frames: int = 90, scale: float = 100.0, axes: int | None = None
) -> tuple[SourceMotion, np.ndarray]:
    """A made dance on a family's skeleton, and the world positions of the engine's joints in it, (T, 22, 3) [m].

    `scale`: file units in a metre. `axes`: a seed for bones with axes of their own in the rest pose, as in glTF; None:
    the axes of the world, as in BVH.
    """
    rows, hang = joints_of(text), REST_POSES[rest]
    places, turns = engine_pose(danced_angles(frames), frames)
    down = {name: Rotation.identity(1) for name in SKELETON.names}
    down |= {f"{side}UpperArm": Rotation.from_euler("Z", [sign * hang]) for side, sign in (("left", -1), ("right", 1))}
    rest_places, rest_turns = engine_pose(down, 1)
    random = np.random.default_rng(axes)
    own = [Rotation.identity() if axes is None else Rotation.random(random_state=random.integers(2**31)) for _ in rows]

    def world(points: np.ndarray, rotations: list[Rotation], row: int) -> tuple[np.ndarray, Rotation]:
        _, _, joint, share = rows[row]
        count = len(points)
        if joint == "floor":
            return np.zeros((count, 3)), Rotation.identity(count)
        index = SKELETON.index(joint)
        tip = BONE_TIPS.get(index)
        bone = np.array(tip if tip is not None else SKELETON.offsets[NEXT[index]], np.float64)
        return points[:, index] + rotations[index].apply(share * bone), rotations[index]

    posed = [world(places, turns, row) for row in range(len(rows))]
    resting = [world(rest_places, rest_turns, row) for row in range(len(rows))]
    count = len(rows)
    translation, rotation = np.zeros((frames, count, 3)), np.zeros((frames, count, 4))
    offsets, rest_rotation = np.zeros((count, 3)), np.zeros((count, 4))
    aligned: list[tuple[Rotation, Rotation]] = []  # of each row, in the dance and at rest, with the bone's own axes
    for row, (_, parent, _, _) in enumerate(rows):
        at_rest = own[row]
        danced = posed[row][1] * resting[row][1][0].inv() * at_rest
        aligned.append((danced, at_rest))
        if parent < 0:
            translation[:, row], offsets[row] = posed[row][0], resting[row][0][0]
            local, still = danced, at_rest
        else:
            before, before_rest = aligned[parent]
            translation[:, row] = before.inv().apply(posed[row][0] - posed[parent][0])
            offsets[row] = before_rest.inv().apply(resting[row][0][0] - resting[parent][0][0])
            local, still = before.inv() * danced, before_rest.inv() * at_rest
        rotation[:, row] = local.as_quat()[:, [3, 0, 1, 2]]
        rest_rotation[row] = still.as_quat()[[3, 0, 1, 2]]
    ends = [row for row in range(count) if row not in {parent for _, parent, _, _ in rows}]
    motion = SourceMotion(
        file="made",
        names=tuple(name for name, _, _, _ in rows),
        parents=np.array([parent for _, parent, _, _ in rows], np.int32),
        offsets=scale * offsets,
        end_parents=np.array(ends, np.int32),
        end_offsets=scale * np.stack([own[row].inv().apply(_tip(rows[row], resting[row][1][0])) for row in ends]),
        translation=scale * translation,
        rotation=rotation,
        rest_rotation=None if axes is None else rest_rotation,
        frame_time=1.0 / 60.0,
        frames_declared=frames,
        channel_count=3 + 3 * count,
    )
    return motion, places


def _tip(row: tuple[str, int, str, float], rest: Rotation) -> np.ndarray:
    """The end of the bone of a joint without children in the rest pose, from the joint [m], in the world's axes."""
    _, _, joint, share = row
    tip = BONE_TIPS.get(SKELETON.index(joint)) if joint != "floor" else None
    return np.asarray(rest.apply((1.0 - share) * np.array(tip if tip is not None else (0.0, 0.0, 0.0)) + 1e-6))


def family_bvh(motion: SourceMotion) -> str:
    """The motion as a BVH file: rotations in the order Z X Y, and places of the joints that move in their parents."""
    children = [[c for c, p in enumerate(motion.parents.tolist()) if p == joint] for joint in range(len(motion.names))]
    tips = dict(zip(motion.end_parents.tolist(), motion.end_offsets.tolist(), strict=True))
    order: list[int] = []
    moving = [j for j in range(len(motion.names)) if j == 0 or np.ptp(motion.translation[:, j], axis=0).max() > 1e-6]

    def write(joint: int) -> str:
        order.append(joint)
        offset = (0.0, 0.0, 0.0) if joint == 0 else motion.offsets[joint]
        moves = "6 Xposition Yposition Zposition" if joint in moving else "3"
        inside = "".join(write(child) for child in children[joint])
        if joint in tips:
            inside = f"End Site\n{{\nOFFSET {' '.join(map(str, tips[joint]))}\n}}\n"
        keyword = "ROOT" if joint == 0 else "JOINT"
        return (
            f"{keyword} {motion.names[joint]}\n{{\nOFFSET {' '.join(f'{v:.6f}' for v in offset)}\n"
            f"CHANNELS {moves} Zrotation Xrotation Yrotation\n{inside}}}\n"
        )

    head = "HIERARCHY\n" + write(0)
    turned = [
        Rotation.from_quat(motion.rotation[:, joint][:, [1, 2, 3, 0]]).as_euler("ZXY", degrees=True) for joint in order
    ]
    columns = [
        column
        for joint, angles in zip(order, turned, strict=True)
        for column in ((motion.translation[:, joint], angles) if joint in moving else (angles,))
    ]
    values = np.concatenate(columns, axis=1)
    lines = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in values)
    return f"{head}MOTION\nFrames: {len(values)}\nFrame Time: {motion.frame_time:.8f}\n{lines}\n"
