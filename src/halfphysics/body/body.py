"""Body: a shape and its skin, and the positions of joints and vertices in a motion."""

from __future__ import annotations

import dataclasses
import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of
from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.validation import real, shown
from halfphysics.body import skinning
from halfphysics.body.shape_space import ShapeSpace, Source
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.rigid_parts import Variant
    from halfphysics.body.skin_hulls import SkinHulls
    from halfphysics.body.symmetry import Symmetry
    from halfphysics.motion.motion import Motion
    from halfphysics.motion.pose import Pose

Array = NDArray[np.float64]

#: Model of the body that comes with the package. Its betas are its own.
FREE = "free"
_ASSET = Path(__file__).parents[1] / "assets" / "body.npz"
_STATURES = (0.4, 2.8)
_MASSES = (1.0, 500.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Body(InNotebook, ReadOnly):
    """A person's shape: skin, joints and skinning. ReadOnly: its arrays are read-only.

    The rest frame is SMPL-X's: y up, z forward, x to the body's left. Files of SMPL-H and SMPL
    are fitted into the 55 SMPL-X joints: a joint that the file does not have is at its parent and
    carries no skin.

    Attributes:
        betas: Shape coefficients, one per shape direction of the model, shape (n,).
        gender: "neutral", "male", "female", or "unknown".
        model: "smplx", "smplh", "smpl", or "free" (the body that comes with the package).
        faces: Triangles, shape (F, 3), int32, counter-clockwise from outside.
        weights: Skinning weights, rows sum to one, shape (V, 55).
        rest_vertices: Skin at rest [m]: template and shape, shape (V, 3).
        rest_joints: Joints at rest [m], shape (55, 3).
        posedirs: Pose blend shapes [m], shape (V, 3, 486), or None.
        hands_mean: Relaxed left and right hand, axis-angle [rad], shape (2, 45), or None.
        hands_components: Their principal components, shape (2, 45, 45), or None.
        source: (path, sha256) of the model file, or None for the default body.
        template_source: (path, sha256) of a per-subject template, or None.
        given_template: Whether an array was the template: no file has this person.
        mean_vertices: Skin of the model's mean shape at rest [m], shape (V, 3), or None: the
            basis of all data that must not depend on the shape.
        mean_joints: Joints of the mean shape [m], shape (55, 3), or None.
        given_mass: Mass of the whole person [kg] that was asked for; None: by volume.
        given_stature: Height [m] that was asked for, to which the shape was scaled; None: as it is.
        given_bones: Bones that were asked for, shape (55, 3) [m], NaN where nothing was; None:
            the model's own.
    """

    betas: Array
    gender: str
    model: str
    faces: NDArray[np.int32]
    weights: Array
    rest_vertices: Array
    rest_joints: Array
    posedirs: Array | None = None
    hands_mean: Array | None = None
    hands_components: Array | None = None
    source: Source | None = None
    template_source: Source | None = None
    given_template: bool = False
    mean_vertices: Array | None = None
    mean_joints: Array | None = None
    given_mass: float | None = None
    given_stature: float | None = None
    given_bones: Array | None = None

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value = np.ascontiguousarray(value)
                if value.flags.writeable:  # the caller's: what is derived from it is kept
                    value = value.copy()
                value = value.view()
                value.setflags(write=False)
                object.__setattr__(self, field.name, value)

    @classmethod
    def default(
        cls,
        betas: ArrayLike | None = None,
        stature: float | None = None,
        mass: float | None = None,
        bones: ArrayLike | None = None,
    ) -> Body:
        """The body that comes with the package, free of third-party licences.

        Without arguments it is one object per process, so its parts are computed once.

        Args:
            betas: Its own shape coefficients (not SMPL-X's), up to 10; None: the mean adult.
            stature: Height [m]: the shape is scaled evenly to it. None: as it is.
            mass: Mass of the person [kg]: masses and inertias of all parts are scaled evenly to
                it. None: the volume times 985 kg/m^3.
            bones: A person's proportions: of every joint its offset from its parent at rest [m],
                shape (55, 3), in the rest frame; row 0 is the pelvis itself. The joints are met
                exactly, the skin follows (`halfphysics.body.proportions`). Rows of NaN are not
                known: such joints follow their parent. None: as the shape has them.

        Raises:
            InputError: Impossible betas, a stature outside 0.4 to 2.8 m or a mass outside 1 to
                500 kg; bones that nobody has, or bones and a stature.
        """
        body = _mean() if betas is None and cls is Body else cls.shaped(_free(), betas, 3)
        body = body.weighing(mass)
        height = _within(stature, "stature", _STATURES, "metres, such as 1.75")
        if bones is not None:
            if height is not None:
                raise InputError(
                    "bones and stature: bones say how tall the person is. Leave out stature, or "
                    "scale the bones"
                )
            return body._of_bones(bones)
        if height is None:
            return body
        factor = height / body.stature
        return dataclasses.replace(
            body,
            rest_vertices=body.rest_vertices * factor,
            rest_joints=body.rest_joints * factor,
            posedirs=None if body.posedirs is None else body.posedirs * factor,
            given_stature=height,
        )

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str] | None = None,
        betas: ArrayLike | None = None,
        gender: str | None = None,
        *,
        model: str | None = None,
        v_template: ArrayLike | str | os.PathLike[str] | None = None,
        mass: float | None = None,
    ) -> Body:
        """A body of an SMPL-X, SMPL-H or SMPL model file, .npz or .pkl (nothing in it is run).

        Args:
            path: The file, or a folder laid out as the smplx package has it
                (``folder/smplx/SMPLX_NEUTRAL.npz`` or ``folder/SMPLX_NEUTRAL.npz``).
                None: the folder ``$HALFPHYSICS_MODELS``; names not found here are looked for
                there too.
            betas: Shape coefficients, any number: zeros are added. None: the mean shape.
            gender: "neutral", "male" or "female": selects a file of a folder, or states the
                gender of a file whose name does not.
            model: "smplx", "smplh" or "smpl": selects a model of a folder. None: the first of
                these that is there.
            v_template: Per-subject template [m] that replaces the model's mean: vertices (V, 3)
                or a PLY or OBJ file.
            mass: As in `default`.

        Warns:
            HalfPhysicsWarning: More betas than the model has shape directions.

        Raises:
            FileError: No such file, not a body model, damaged, or a pickle of more than data.
            InputError: Impossible betas, gender, model or template, or a folder where several
                files fit.
        """
        from halfphysics.body.model_files import read_model

        space = read_model(path, gender=gender, model=model, v_template=v_template)
        return cls.shaped(space, betas, stacklevel=3).weighing(mass)

    @classmethod
    def shaped(cls, space: ShapeSpace, betas: ArrayLike | None = None, stacklevel: int = 2) -> Body:
        """A body of a model that has been read: one file serves many shapes.

        Args:
            space: A result of `halfphysics.body.model_files.read_model`.
            betas: As in `load`.
            stacklevel: Of warnings.
        """
        full = space.betas(betas, stacklevel=stacklevel + 1)
        vertices, joints = space.shaped(full)
        mean_vertices, mean_joints = space.shaped(np.zeros(0))
        return cls(
            betas=full,
            gender=space.gender,
            model=space.model,
            faces=space.faces,
            weights=space.weights,
            rest_vertices=vertices,
            rest_joints=joints,
            posedirs=space.posedirs,
            hands_mean=space.hands_mean,
            hands_components=space.hands_components,
            source=space.source,
            template_source=space.template_source,
            given_template=space.given_template,
            mean_vertices=mean_vertices,
            mean_joints=mean_joints,
        )

    @property
    def stature(self) -> float:
        """Height of the skin at rest [m], soles to crown."""
        return float(np.ptp(self.rest_vertices[:, 1]))

    def joints(self, motion: Motion | Pose) -> Array:
        """World positions of the joints [m], shape (T, 55, 3); of a pose (55, 3)."""
        return self.joint_frames(motion)[0]

    def joint_frames(self, motion: Motion | Pose) -> tuple[Array, Array]:
        """World frames of the joints.

        The pelvis is at ``axes @ rest_joints[0] + translation``.

        Returns:
            Positions (T, 55, 3) [m] and unit quaternions (T, 55, 4), wxyz, world from joint; of
            a pose (55, 3) and (55, 4).

        Raises:
            InputError: `motion` has not 55 rotations per frame.
        """
        rotations, root, single = self._state(motion)
        positions, quaternions = skinning.kinematics(rotations, root, self.rest_joints)
        return (positions[0], quaternions[0]) if single else (positions, quaternions)

    def vertices(
        self,
        motion: Motion | Pose,
        frames: int | slice | Sequence[int] | NDArray[np.integer] | None = None,
        *,
        indices: ArrayLike | None = None,
        threads: int = 1,
    ) -> Array:
        """World positions of the skin [m].

        Args:
            motion: A motion, or one pose.
            frames: Which frames, as an index of numpy; None: all. A single number gives (V, 3).
            indices: Which vertices, shape (n,); None: all.
            threads: Number of threads; the result is the same to the last bit for any number.

        Returns:
            Vertices, shape (T, V, 3); of a pose or one frame (V, 3).

        Raises:
            InputError: `motion` has not 55 rotations per frame, or `frames` or `indices` are out
                of range.
        """
        rotations, root, single = self._state(motion)
        if frames is not None:
            if single:
                raise InputError("frames: a single pose has no frames to choose from")
            rotations, root, single = _pick(rotations, root, frames)
        positions, quaternions = skinning.kinematics(rotations, root, self.rest_joints)
        out = skinning.skin(
            self.skin,
            rotations,
            positions,
            quaternions,
            indices=indices,  # type: ignore[arg-type]
            threads=threads,
        )
        return out[0] if single else out

    @property
    def mass(self) -> float:
        """Mass of the person [kg], the sum over the rigid parts."""
        return self.variant.mass

    def weighing(self, mass: float | None) -> Body:
        """The same body of another mass [kg]; None: the same. Raises `InputError` as `default`."""
        given = _within(mass, "mass", _MASSES, "kilograms, such as 72.5")
        return self if given is None else dataclasses.replace(self, given_mass=given)

    def _of_bones(self, bones: ArrayLike) -> Body:
        """The same person with other bones."""
        from halfphysics.body.proportions import checked_bones, proportioned

        given = checked_bones(bones, self.rest_joints)
        vertices, maps = proportioned(self.rest_vertices, self.rest_joints, self.weights, given)
        shapes = self.posedirs
        if shapes is not None:
            shapes = shapes * (self.weights @ maps.girths)[:, None, None]
        body = dataclasses.replace(
            self,
            rest_vertices=vertices,
            rest_joints=maps.joints,
            posedirs=shapes,
            given_bones=given,
        )
        low, high = _STATURES
        if not low <= body.stature <= high:
            raise InputError(
                f"bones: found those of a person of {body.stature:.3g} m, expected {low:g} to "
                f"{high:g} metres"
            )
        return body

    @cached_property
    def skin(self) -> skinning.Skin:
        """The arrays for `halfphysics.body.skinning`."""
        return skinning.Skin(
            rest_vertices=self.rest_vertices,
            rest_joints=self.rest_joints,
            weights=self.weights,
            posedirs=self.posedirs,
        )

    @cached_property
    def main_joint(self) -> NDArray[np.int64]:
        """Of every skin vertex the joint with the largest weight (V,)."""
        joint: NDArray[np.int64] = np.argmax(self.weights, axis=1)
        joint.setflags(write=False)
        return joint

    @cached_property
    def variant(self) -> Variant:
        """The 55 rigid parts of this shape, made once and kept for the next process."""
        from halfphysics.body.body_cache import variant_of

        variant = variant_of(self)
        return variant if self.given_mass is None else variant.weighing(self.given_mass)

    @cached_property
    def symmetry(self) -> Symmetry | None:
        """Which vertices and faces of the model's mean skin mirror which; None: it is uneven."""
        from halfphysics.body.symmetry import symmetry_of

        mean = self.rest_vertices if self.mean_vertices is None else self.mean_vertices
        return symmetry_of(self.faces, mean)

    @cached_property
    def skin_hulls(self) -> SkinHulls:
        """Vertex sets of whole faces, whose hulls cover the skin at every pose.

        The same for all shapes and statures of a model.
        """
        from halfphysics.body.skin_hulls import skin_hulls

        if self.mean_vertices is None or self.mean_joints is None:
            return skin_hulls(self.faces, self.weights, self.rest_vertices, self.rest_joints)
        return skin_hulls(self.faces, self.weights, self.mean_vertices, self.mean_joints)

    @cached_property
    def skin_corners(self) -> SkinHulls:
        """`skin_hulls` without vertices that are inside their hull at every pose of this shape."""
        from halfphysics.body.body_cache import corners_of

        return corners_of(self)

    def save_mjcf(self, path: str | os.PathLike[str]) -> None:
        """Write the 55 rigid parts as a MuJoCo model (MJCF) that stock MuJoCo opens.

        Raises:
            FileError: The file cannot be written; no partial file remains.
        """
        from halfphysics.base.atomic import atomic_write
        from halfphysics.body.mjcf_person import to_mjcf

        text = to_mjcf(self.variant)
        with atomic_write(path) as handle:
            handle.write(text.encode("utf-8"))

    def __reduce_ex__(self, protocol: Any) -> Any:
        # The default body is one object in every process: it is named, not sent.
        if _mean.cache_info().currsize and self is _mean():
            return Body.default, ()
        return super().__reduce_ex__(protocol)

    def _state(self, motion: Motion | Pose) -> tuple[Array, Array, bool]:
        """Rotations (T, 55, 3), pelvis positions (T, 3), and whether it was a single pose."""
        try:
            rotations = np.asarray(array_of(motion.rotations), dtype=np.float64)
            translation = np.asarray(array_of(motion.translation), dtype=np.float64)
        except AttributeError:
            raise InputError(
                f"motion: found {type(motion).__name__}, expected a Motion or a Pose"
            ) from None
        single = rotations.ndim == 2
        if rotations.shape[-2:] != (N_JOINTS, 3) or translation.shape != (
            *rotations.shape[:-2],
            3,
        ):
            raise InputError(
                f"motion: found rotations {rotations.shape} and translation {translation.shape}, "
                f"expected (T, {N_JOINTS}, 3) and (T, 3), or those of one frame"
            )
        axes = np.asarray(array_of(getattr(motion, "axes", np.eye(3))), dtype=np.float64)
        root = translation + axes @ self.rest_joints[0]
        return rotations.reshape(-1, N_JOINTS, 3), root.reshape(-1, 3), single

    def __repr__(self) -> str:
        origin = "" if self.source is None else f", {self.source.path}"
        return (
            f"Body({self.model} {self.gender}, {self.stature:.3f} m, "
            f"{len(self.rest_vertices)} vertices{origin})"
        )


@cache
def _free() -> ShapeSpace:
    from halfphysics.body.model_files import read_model

    space = read_model(_ASSET, gender="neutral")
    return dataclasses.replace(space, model=FREE, source=None)


def free_regressor() -> Array:
    """Joints of the free body's mean shape from its skin (55, V)."""
    return _free().joint_regressor


@cache
def _mean() -> Body:
    """The default body with the mean shape."""
    return Body.shaped(_free())


def _within(value: float | None, name: str, limits: tuple[float, float], unit: str) -> float | None:
    """A number within limits, or None; `unit` is for messages."""
    if value is None:
        return None
    low, high = limits
    number = real(value)
    if number is None:
        raise InputError(f"{name}: found {shown(value)}, expected {unit}")
    if not low <= number <= high:
        found, unit = f"{number:g}", unit.split(",")[0]
        raise InputError(f"{name}: found {found}, expected {low:g} to {high:g} {unit}")
    return number


def _pick(
    rotations: Array, root: Array, frames: int | slice | Sequence[int] | NDArray[np.integer]
) -> tuple[Array, Array, bool]:
    try:
        frames = array_of(frames)
        single = not isinstance(frames, slice) and np.ndim(frames) == 0
        key = [operator.index(frames)] if single else frames  # type: ignore[arg-type]
        rotations, root = rotations[key], root[key]
    except (IndexError, TypeError, ValueError) as error:
        raise InputError(f"frames: found {frames!r}, of {len(root)} frames: {error}") from None
    if rotations.ndim != 3:
        raise InputError(f"frames: found {frames!r}, expected a number, a slice or a list of them")
    return rotations, root, single
