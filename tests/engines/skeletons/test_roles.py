"""Roles told from names, for every convention that files come in."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import SkeletonError
from engines.skeletons import SMPL22, roles
from engines.skeletons.skeleton import Skeleton

PARTS = ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")


def both(*names: str) -> dict[str, str]:
    """Roles of both sides from eight names of the left side, "L" or "Left" or "l" marked by {}; "" for none."""
    found = {}
    for side, marks in (("left", ("Left", "L", "l", "left")), ("right", ("Right", "R", "r", "right"))):
        for part, name in zip(PARTS, names, strict=True):
            if name:
                found[f"{side}_{part}"] = name.format(*marks)
    return found


def trunk(*names: str) -> dict[str, str]:
    parts = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")
    return {part: name for part, name in zip(parts, names, strict=True) if name}


CONVENTIONS = {
    "cmu bvh": (
        trunk("Hips", "LowerBack", "Spine", "Spine1", "Neck1", "Head")
        | both("{0}Shoulder", "{0}Arm", "{0}ForeArm", "{0}Hand", "{0}UpLeg", "{0}Leg", "{0}Foot", "{0}ToeBase"),
        ["LHipJoint", "RHipJoint", "Neck", "LeftFingerBase", "LeftHandIndex1", "LThumb", "RThumb", "RightHandIndex1"],
    ),
    "cmu asf": (
        trunk("root", "lowerback", "upperback", "thorax", "lowerneck", "head")
        | both("{2}clavicle", "{2}humerus", "{2}radius", "{2}wrist", "{2}femur", "{2}tibia", "{2}foot", "{2}toes"),
        ["lhipjoint", "rhipjoint", "upperneck", "lhand", "rhand", "lfingers", "rfingers", "lthumb", "rthumb"],
    ),
    "cgspeed": (
        trunk("hip", "abdomen", "", "chest", "neck", "head")
        | both("{2}Collar", "{2}Shldr", "{2}ForeArm", "{2}Hand", "{2}Thigh", "{2}Shin", "{2}Foot", ""),
        ["lButtock", "rButtock", "leftEye", "rightEye", "lThumb1", "lIndex1", "rMid2", "rPinky1"],
    ),
    "mixamo": (
        trunk(*(f"mixamorig:{n}" for n in ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")))
        | both(*(f"mixamorig:{{0}}{n}" for n in
                 ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"))),
        ["mixamorig:HeadTop_End", "mixamorig:LeftHandThumb1", "mixamorig:LeftToe_End", "mixamorig:RightHandIndex3"],
    ),
    "mixamo without colon": (
        trunk(*(f"mixamorig{n}" for n in ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")))
        | both(*(f"mixamorig{{0}}{n}" for n in
                 ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"))),
        ["mixamorigHeadTop_End"],
    ),
    "bandai-namco": (
        trunk("Hips", "Spine", "", "Chest", "Neck", "Head")
        | both("Shoulder_{1}", "UpperArm_{1}", "LowerArm_{1}", "Hand_{1}", "UpperLeg_{1}", "LowerLeg_{1}", "Foot_{1}",
               "Toes_{1}"),
        ["joint_Root"],
    ),
    "smpl": (
        trunk("Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Head")
        | both(*(f"{{1}}_{n}" for n in ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot"))),
        ["L_Hand", "R_Hand"],
    ),
    "smpl of maya": (
        trunk(*(f"m_avg_{n}" for n in ("Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Head")))
        | both(*(f"m_avg_{{1}}_{n}" for n in
                 ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot"))),
        ["m_avg_root", "m_avg_L_Hand"],
    ),
    "biped": (
        trunk("Bip01 Pelvis", "Bip01 Spine", "Bip01 Spine1", "Bip01 Spine2", "Bip01 Neck", "Bip01 Head")
        | both(*(f"Bip01 {{1}} {n}" for n in
                 ("Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0"))),
        ["Bip01", "Bip01 L Finger0", "Bip01 L Finger01", "Bip01 Footsteps", "Bip01 HeadNub"],
    ),
    "biped with underscores": (
        trunk("Bip001_Pelvis", "Bip001_Spine", "", "Bip001_Spine1", "Bip001_Neck", "Bip001_Head")
        | both(*(f"Bip001_{{1}}_{n}" for n in
                 ("Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0"))),
        ["Bip001"],
    ),
    "rigify": (
        trunk("spine", "spine.001", "spine.002", "spine.003", "spine.004", "spine.006")
        | both(*(f"{n}.{{1}}" for n in
                 ("shoulder", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe"))),
        ["spine.005", "pelvis.L", "pelvis.R", "heel.02.L", "breast.L", "breast.R", "thumb.01.L", "palm.02.R"],
    ),
    "rigify deform": (
        trunk("DEF-hips", "DEF-spine", "", "DEF-chest", "DEF-neck", "DEF-head")
        | both(*(f"DEF-{n}.{{1}}" for n in
                 ("shoulder", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe"))),
        ["DEF-upper_arm.L.001", "DEF-thigh.R.001"],
    ),
    "unreal": (
        trunk("pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head")
        | both(*(f"{n}_{{2}}" for n in
                 ("clavicle", "upperarm", "lowerarm", "hand", "thigh", "calf", "foot", "ball"))),
        ["root", "upperarm_twist_01_l", "ik_foot_root", "ik_foot_l", "ik_hand_gun", "index_01_l", "thigh_twist_01_r"],
    ),
    "vrm": (
        trunk("J_Bip_C_Hips", "J_Bip_C_Spine", "J_Bip_C_Chest", "J_Bip_C_UpperChest", "J_Bip_C_Neck", "J_Bip_C_Head")
        | both(*(f"J_Bip_{{1}}_{n}" for n in
                 ("Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "ToeBase"))),
        ["J_Sec_Hair1_01", "J_Bip_L_Thumb1"],
    ),
    "xsens": (
        trunk("Hips", "Chest", "Chest3", "Chest4", "Neck", "Head")
        | both(*(f"{{0}}{n}" for n in ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Toe"))),
        ["Chest2"],
    ),
    "kinect": (
        trunk("hip_center", "spine", "", "", "shoulder_center", "head")
        | both("", *(f"{{3}}_{n}" for n in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot"))),
        ["left_hand", "right_hand"],
    ),
    "kinect 2": (
        trunk("SpineBase", "SpineMid", "", "", "SpineShoulder", "Head")
        | both("", *(f"{n}{{0}}" for n in ("Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot"))),
        ["HandLeft", "HandTipLeft", "ThumbLeft", "HandRight", "Neck"],
    ),
    "motionbuilder": (
        trunk("Character1_Hips", "Character1_Spine", "Character1_Spine1", "Character1_Spine2", "Character1_Neck",
              "Character1_Head")
        | both(*(f"Character1_{{0}}{n}" for n in
                 ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"))),
        ["Character1_Reference", "Character1_LeftHandThumb1", "Character1_LeftForeArmRoll"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_conventions(convention, backwards):
    """All roles are found, nothing else is taken for one; the order of the names matters for the trunk alone."""
    expected, others = CONVENTIONS[convention]
    middle = [expected[role] for role in roles.ROLES if role in expected and "_" not in role]
    sided = [name for role, name in expected.items() if "_" in role]
    extra = [name for name in others if name not in ("Neck", "Chest2", "upperneck", "spine.005")]
    if convention == "cmu bvh":
        middle.insert(middle.index("Neck1"), "Neck")
    elif convention in ("kinect 2", "cmu asf"):
        middle.insert(-1, {"kinect 2": "Neck", "cmu asf": "upperneck"}[convention])
    elif convention == "xsens":
        middle.insert(middle.index("Chest3"), "Chest2")
    elif convention == "rigify":
        middle.insert(-1, "spine.005")
    names = [*middle, *sided, *extra]
    if backwards:
        names = [*extra[::-1], *middle, *sided[::-1]]
    assert roles.recognise(names) == expected


def test_smpl22_is_itself():
    found = roles.recognise(SMPL22.joints)
    assert found == {name: name for name in SMPL22.joints}
    assert list(found) == list(SMPL22.joints) == list(roles.ROLES)


def test_nothing_is_made_up():
    assert roles.recognise(["Bone", "Bone.001", "tail", "wheel_L", "", "123", "Ünïcode"]) == {}
    assert roles.recognise([]) == {}


@pytest.mark.parametrize(
    ("spine", "expected"),
    [
        ([], {}),
        (["Spine"], {"spine1": "Spine"}),
        (["Spine", "Chest"], {"spine1": "Spine", "spine3": "Chest"}),
        (["Spine", "Spine1", "Spine2"], {"spine1": "Spine", "spine2": "Spine1", "spine3": "Spine2"}),
        ([f"spine_0{i}" for i in range(1, 6)], {"spine1": "spine_01", "spine2": "spine_03", "spine3": "spine_05"}),
    ],
)
def test_the_spine_is_spread(spine, expected):
    found = roles.recognise(["Hips", *spine, "Neck", "Head"])
    assert {role: joint for role, joint in found.items() if role.startswith("spine")} == expected


@pytest.mark.parametrize(
    ("name", "side", "rest"),
    [
        ("LeftUpLeg", "left", "upleg"),
        ("mixamorig:RightHandThumb2", "right", "handthumb2"),
        ("lfemur", "left", "femur"),
        ("lowerback", "", "lowerback"),
        ("rootJoint", "", "rootjoint"),
        ("thigh.L", "left", "thigh"),
        ("Bip01 R Toe0", "right", "toe0"),
        ("LHipJoint", "left", "hipjoint"),
        ("clavicle_r", "right", "clavicle"),
        ("Armature|Hips", "", "hips"),
    ],
)
def test_side_and_rest(name, side, rest):
    assert roles.split_name(name) == (side, rest)


def test_mirror_pairs_include_what_plays_no_role():
    pairs = roles.mirror_pairs(["Hips", "LHipJoint", "RHipJoint", "LeftHandIndex1", "RightHandIndex1", "LeftEye"])
    assert pairs == (("LHipJoint", "RHipJoint"), ("LeftHandIndex1", "RightHandIndex1"))


def bare(skeleton: Skeleton, offsets: np.ndarray | None = None) -> Skeleton:
    return Skeleton(
        "bare", skeleton.joints, skeleton.parents, skeleton.offsets if offsets is None else offsets
    )  # fmt: skip


def test_with_roles_finds_what_smpl22_states():
    found = roles.with_roles(bare(SMPL22))
    assert found.feet == SMPL22.feet
    assert set(found.mirror_pairs) == set(SMPL22.mirror_pairs)
    assert set(found.hinges) == set(SMPL22.hinges)
    for joint, axis in SMPL22.hinges.items():
        np.testing.assert_allclose(found.hinges[joint], axis, atol=0.1)
        assert np.linalg.norm(found.hinges[joint]) == pytest.approx(1.0)


def test_hinges_turn_with_the_rest_pose():
    """A rest pose that faces +X has its hinges turned along."""
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    found = roles.with_roles(bare(SMPL22, SMPL22.offsets @ turn.T))
    for joint, axis in roles.with_roles(bare(SMPL22)).hinges.items():
        np.testing.assert_allclose(found.hinges[joint], turn @ axis, atol=1e-9)


def test_an_a_pose_has_hinges_across_its_arms():
    offsets = np.array(SMPL22.offsets)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for part in ("elbow", "wrist"):
            offsets[SMPL22.index(f"{side}_{part}")] = [0.18 * sign, -0.18, 0.0]
    found = roles.with_roles(bare(SMPL22, offsets))
    np.testing.assert_allclose(found.hinges["left_elbow"], np.array([-1, -1, 0]) / np.sqrt(2), atol=0.02)
    np.testing.assert_allclose(found.hinges["right_elbow"], np.array([-1, 1, 0]) / np.sqrt(2), atol=0.02)


@pytest.mark.parametrize("axis", [0, 2])
def test_a_rest_pose_that_does_not_stand_has_no_hinges_but_all_else(axis):
    """As Bandai-Namco's, whose bones all lie along one axis."""
    lengths = np.linalg.norm(SMPL22.offsets, axis=-1, keepdims=True)
    found = roles.with_roles(bare(SMPL22, lengths * np.eye(3)[axis]))
    assert not found.hinges
    assert found.feet == SMPL22.feet and len(found.mirror_pairs) == 8


def test_body_height():
    known = roles.recognise(SMPL22.joints)
    assert roles.body_height(SMPL22, known) == pytest.approx(1.73, abs=0.02)
    assert roles.body_height(SMPL22, {}) == 0.0
    assert roles.path_length(SMPL22, "left_hip", "left_ankle") == pytest.approx(0.4032 + 0.4277)
    with pytest.raises(SkeletonError, match="does not hang from"):
        roles.path_length(SMPL22, "left_hip", "right_ankle")
