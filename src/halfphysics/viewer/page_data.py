"""What the script in a browser needs beside viser's scene: marks, contacts, cameras, layers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from halfphysics.body.body import Body
from halfphysics.motion.skeleton import PARENTS
from halfphysics.render.viewpoint import FOV
from halfphysics.viewer.arrange import Arrangement
from halfphysics.viewer.bones import GRAIN
from halfphysics.viewer.coloring import RAMP
from halfphysics.viewer.comparison import choices
from halfphysics.viewer.figure import strongest
from halfphysics.viewer.first_picture import first_camera
from halfphysics.viewer.marks import rows
from halfphysics.viewer.packing import packed
from halfphysics.viewer.skin_forces import skin_document
from halfphysics.viewer.stage import Stage
from halfphysics.viewer.whereabouts import goes_far, track


def common_data(
    stages: Sequence[Stage], labels: Sequence[str], title: str, frames: Sequence[Sequence[int]]
) -> dict[str, Any]:
    """What both a page and the page of `view` need.

    Args:
        stages: The stages.
        labels: Names of the results.
        title: Title of the tab.
        frames: For each result, its frames that can be shown.
    """
    results = [stage.drawing.result for stage in stages]
    numbers = [(k, j) for k, result in enumerate(results) for j in range(len(result.people))]
    return {
        "title": title,
        "marks": [row.document() for row in rows(results, labels)],
        "ramp": [list(color) for color in RAMP],
        "people": [stages[k].path(f"person/{j}") for k, j in numbers],
        "of": numbers,
        "skin": [
            skin_document(result, shown) for result, shown in zip(results, frames, strict=True)
        ],
        "compare": choices(stages, labels),
    }


def camera_data(stages: Sequence[Stage], row: Arrangement, frames: Sequence[int]) -> dict[str, Any]:
    """What the cameras of a page need, by the page's frames."""
    boxes = track([stage.drawing for stage in stages], row.offsets, frames)
    return {
        "fov": math.radians(FOV),
        "direction": [round(float(x), 5) for x in row.direction],
        "first": first_camera(row),
        "track": np.round(boxes, 3).tolist(),
        "follow": goes_far(boxes),
    }


def layer_data(stages: Sequence[Stage], support: bool) -> list[dict[str, Any]]:
    """The layers that a page can show and hide: parents of nodes."""

    def layer(name: str, label: str, *nodes: str) -> dict[str, Any]:
        paths = [stage.path(node) for stage in stages for node in nodes]
        return {"id": name, "label": label, "on": True, "nodes": paths}

    there = {name for stage in stages for name in stage.layers}
    contacts = any(len(stage.drawing.result.contacts.frame) for stage in stages)
    found = [
        layer(name, label, *nodes)
        for name, label, *nodes in (
            ("body", "Body", "person"),
            ("ghost", "Ghost", "ghost"),
            ("objects", "Objects", "object"),
            ("scene", "Scene", "static", "edges"),
        )
        if name in there
    ]
    if contacts:
        found.append({"id": "skin", "label": "Skin by force", "on": True, "nodes": []})
        found.append(layer("arrows", "Force arrows", "contact/arrow"))
        found.append(layer("points", "Contact points", "contact/point"))
    if support:
        found.append(layer("support", "Support", "support"))
    return found


def body_data(body: Body) -> dict[str, Any]:
    """The skin of a body with all joints, for people who are dropped onto a page.

    Vertices are in multiples of `GRAIN`, faces as differences, weights in multiples of 1/65535.
    """
    weights = strongest(np.asarray(body.weights))
    order = np.argsort(-weights, axis=1, kind="stable")[:, :4]
    return {
        "vertices": packed(np.round(np.asarray(body.rest_vertices) / GRAIN), "<i2"),
        "faces": packed(
            np.diff(np.asarray(body.faces, dtype=np.int64).reshape(-1), prepend=0), "<i4"
        ),
        "indices": packed(order, "u1"),
        "weights": packed(65535.0 * np.take_along_axis(weights, order, axis=1) + 0.5, "<u2"),
        "joints": np.round(np.asarray(body.rest_joints), 5).tolist(),
        "parents": np.asarray(PARENTS).tolist(),
    }
