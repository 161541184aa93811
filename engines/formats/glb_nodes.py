"""The tree of a .glb's nodes: who hangs from whom, which of them are joints, and what they are called."""

from __future__ import annotations

from pathlib import Path

from engines.errors import FormatError
from engines.formats.files import MAX_JOINTS
from engines.formats.gltf import Gltf


def node_parents(gltf: Gltf) -> list[int]:
    """Parent of every node, -1 for none; each node has one at most, and there are no circles.

    Raises:
        FormatError: that is not so.
    """
    nodes = gltf.items("nodes")
    parents = [-1] * len(nodes)
    for number, node in enumerate(nodes):
        for child in node.get("children", ()):
            gltf.item("nodes", child)
            if parents[child] >= 0:
                raise FormatError(gltf.path, f"node {child} hangs from two others.")
            parents[child] = number
    depth = [0] * len(nodes)  # 0: not yet known
    for number in range(len(nodes)):
        chain, at = [], number
        while at >= 0 and not depth[at]:
            depth[at] = -1
            chain.append(at)
            at = parents[at]
        if at >= 0 and depth[at] == -1:
            raise FormatError(gltf.path, f"node {at} hangs from itself.")
        for step, node in enumerate(reversed(chain), start=(depth[at] if at >= 0 else 0) + 1):
            depth[node] = step
    return parents


def _lineage(path: Path, node: int, parents: list[int]) -> list[int]:
    """The node's ancestors from the topmost down, itself last."""
    line = [node]
    while parents[line[-1]] >= 0:
        line.append(parents[line[-1]])
        if len(line) > MAX_JOINTS:
            raise FormatError(path, f"has joints below more than {MAX_JOINTS:,} others; accepted: at most as many.")
    return line[::-1]


def joint_nodes(gltf: Gltf, moving: list[int], parents: list[int]) -> tuple[list[int], list[int]]:
    """The nodes above the root, topmost first, and the joints, parents first.

    Args:
        gltf: the file.
        moving: nodes that count as joints where there is no skin.
        parents: of all nodes.

    Raises:
        FormatError: there are none, or more than any skeleton has.
    """
    skins = [skin["joints"] for skin in gltf.items("skins")]
    members = max(skins, key=len) if skins else moving
    if not members or len(members) > MAX_JOINTS:
        raise FormatError(gltf.path, f"has a skeleton of {len(members):,} joints; accepted: 1 to {MAX_JOINTS:,}.")
    for node in members:
        gltf.item("nodes", node)
    lines = [_lineage(gltf.path, node, parents) for node in dict.fromkeys(members)]
    tops = [line[0] for line in lines]
    main = max(dict.fromkeys(tops), key=tops.count)
    lines = [line for line in lines if line[0] == main]
    shortest = min(len(line) for line in lines)
    shared = next((i for i in range(shortest) if len({line[i] for line in lines}) > 1), shortest)
    depth = {node: level for line in lines for level, node in enumerate(line)}
    joints = sorted({node for line in lines for node in line[shared - 1 :]})
    if len(joints) > MAX_JOINTS:
        raise FormatError(gltf.path, f"has {len(joints):,} joints; accepted: at most {MAX_JOINTS:,}.")
    if any(parents[j] > j for j in joints if j != lines[0][shared - 1]):
        joints.sort(key=lambda node: depth[node])
    return lines[0][: shared - 1], joints


def node_names(gltf: Gltf, nodes: list[int]) -> tuple[str, ...]:
    """Names of nodes, no two alike; a node without one is called by its number."""
    names: dict[str, None] = {}
    for node in nodes:
        stated = gltf.item("nodes", node).get("name")
        bare = stated.strip()[:200] if isinstance(stated, str) and stated.strip() else f"node_{node}"
        name, count = bare, 2
        while name in names:
            name, count = f"{bare}_{count}", count + 1
        names[name] = None
    return tuple(names)
