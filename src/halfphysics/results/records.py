"""Records of bodies and scenes in result files: plain data from which they are loaded again.

Licensed models and meshes are named by path and SHA-256; their content is never written.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base.digests import sha256_of
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.body.shape_space import Source
    from halfphysics.scene.scene import Scene

#: Key of a mesh without a file: only its digest is kept.
IN_MEMORY = "in_memory"
_MEND_BODY = "Put it back, or pass body= to Result.load"
_SAME_STATURE = 1e-9  # rounding of a sum of shape directions [m]


@dataclass(frozen=True, eq=False)
class SceneRecord:
    """A scene as the data of a scene file (`Scene.save`), its meshes by absolute path."""

    document: Mapping[str, Any]
    origin: str

    @staticmethod
    def of(scene: Scene) -> SceneRecord:
        """The record of a scene."""
        from halfphysics.scene.scene_writer import scene_document

        document = json.loads(json.dumps(scene_document(scene)))
        for group in ("statics", "objects", "moving"):
            for item in document.get(group, {}).values():
                if isinstance(item.get("mesh"), dict):
                    item["mesh"] = {IN_MEMORY: _identity(item["mesh"])}
                if isinstance(item.get("pieces"), list):
                    item["pieces"] = {IN_MEMORY: [_identity(piece) for piece in item["pieces"]]}
        return SceneRecord(document, "this session")

    def missing(self) -> dict[str, str]:
        """Items that cannot be loaded: name -> reason."""
        from halfphysics.scene.mjcf_text import lost_files

        lost = {}
        for group in ("statics", "objects", "moving"):
            for name, item in self.document.get(group, {}).items():
                mesh = item.get("mesh")
                if isinstance(mesh, dict):
                    lost[name] = "its mesh came from no file"
                elif isinstance(item.get("pieces"), dict):
                    lost[name] = "its pieces came from no file"
                elif mesh is not None and not Path(mesh).is_file():
                    lost[name] = f"{mesh} is not there"
        for name, item in self.document.get("articulated", {}).items():
            if "file" in item and not Path(item["file"]).is_file():
                lost[name] = f"{item['file']} is not there"
            elif "xml" in item and (gone := lost_files(item["xml"])):
                lost[name] = f"{', '.join(gone)} is not there"
        return lost

    def make(self) -> Scene:
        """The scene without missing items (with a warning; loaded once)."""
        return self._scene

    @cached_property
    def _scene(self) -> Scene:
        from halfphysics.scene.scene_file import scene_from_document

        lost = self.missing()
        if lost:
            warnings.warn(
                f"{self.origin}: left out of the scene: "
                + "; ".join(f"{name} ({why})" for name, why in lost.items())
                + ". Put the files back, or pass scene= to Result.load",
                HalfPhysicsWarning,
                stacklevel=4,
            )
        document = dict(self.document)
        for group in ("statics", "objects", "moving", "articulated"):
            items = document.get(group, {})
            document[group] = {name: item for name, item in items.items() if name not in lost}
        for group in ("friction", "ignore"):
            pairs = document.get(group, [])
            document[group] = [pair for pair in pairs if not set(pair[:2]) & set(lost)]
        with warnings.catch_warnings():
            # The warning was given when the scene was first loaded.
            warnings.filterwarnings("ignore", ".*(convex hull|pieces)", HalfPhysicsWarning)
            return scene_from_document(document, Path(self.origin))


@dataclass(frozen=True, eq=False)
class BodyRecord:
    """A body as its model file (None: the default body), gender and shape."""

    data: Mapping[str, Any]
    origin: str

    @staticmethod
    def of(body: Body) -> BodyRecord:
        """The record of a body."""
        return BodyRecord(
            {
                "model": body.model,
                "gender": body.gender,
                "betas": body.betas.tolist(),
                "stature": body.stature,
                "given_stature": body.given_stature,
                "mass": body.given_mass,
                "bones": _bones_document(body),
                "source": _source(body.source),
                "template_source": _source(body.template_source),
                **({"template": IN_MEMORY} if body.given_template else {}),
            },
            "this session",
        )

    def make(self) -> Body:
        """The body (loaded once).

        Raises:
            FileError: Its model file is missing or has changed, or it has none.
        """
        return self._body

    @cached_property
    def _body(self) -> Body:
        from halfphysics.body.body import FREE, Body

        betas = np.array(self.data["betas"], dtype=np.float64)
        stature, mass = self.data["stature"], self.data.get("mass")
        if self.data["model"] == FREE:
            bones = self.data.get("bones")
            if bones is not None:
                rows = [[np.nan] * 3 if row is None else row for row in bones]
                return Body.default(betas, mass=mass, bones=rows)
            if self.data.get("given_stature") is not None:  # to the last bit
                return Body.default(betas, stature=self.data["given_stature"], mass=mass)
            body = Body.default(betas, mass=mass)
            same = abs(body.stature - stature) < _SAME_STATURE
            return body if same else Body.default(betas, stature=stature, mass=mass)
        if self.data["source"] is None:
            raise FileError(
                f"{self.origin}: the {self.data['model']} body came from no file. {_MEND_BODY}"
            )
        if "template" in self.data:
            raise FileError(f"{self.origin}: the body's template came from no file. {_MEND_BODY}")
        template, gender = self.data["template_source"], self.data["gender"]
        return Body.load(
            self._unchanged(self.data["source"], "body model"),
            betas=betas,
            gender=None if gender == "unknown" else gender,
            v_template=None if template is None else self._unchanged(template, "template"),
            mass=mass,
        )

    def _unchanged(self, source: Mapping[str, str], kind: str) -> Path:
        path = Path(source["path"])
        if not path.is_file():
            raise FileError(f"{self.origin}: the {kind} {path} is not there. {_MEND_BODY}")
        found = sha256_of(path)
        if found != source["sha256"]:
            raise FileError(
                f"{self.origin}: the {kind} {path} has changed: found SHA-256 {found[:12]}..., "
                f"expected {source['sha256'][:12]}.... {_MEND_BODY}"
            )
        return path


def _identity(mesh: Mapping[str, Any]) -> dict[str, Any]:
    content = json.dumps(mesh, sort_keys=True).encode()
    return {
        "vertices": len(mesh["vertices"]),
        "faces": len(mesh["faces"]),
        "sha256": hashlib.sha256(content).hexdigest(),
    }


def _bones_document(body: Body) -> list[list[float] | None] | None:
    """The bones that a body was given; None in place of what is not known."""
    if body.given_bones is None:
        return None
    return [None if np.isnan(row[0]) else row.tolist() for row in body.given_bones]


def _source(source: Source | None) -> dict[str, str] | None:
    if source is None:
        return None
    return {"path": str(Path(source.path).resolve()), "sha256": source.sha256}


def checked_document(data: Any, what: str, keys: tuple[str, ...]) -> dict[str, Any]:
    """`data` as a dict that has `keys`; raises `InputError` naming `what`."""
    if not isinstance(data, dict) or any(key not in data for key in keys):
        found = sorted(data) if isinstance(data, dict) else type(data).__name__
        raise InputError(f"{what}: found {found}, expected {', '.join(keys)}")
    return data
