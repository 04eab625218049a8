"""Motion: SMPL-X pose parameters of one person over T frames, in a z-up world."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import validation
from halfphysics.base.arrays import as_array
from halfphysics.base.axes import axes_of, turned
from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.progress import over
from halfphysics.base.validation import frame_rate, number, shown
from halfphysics.errors import InputError
from halfphysics.motion.adapted_hold import AdaptedHold, check_adaptation
from halfphysics.motion.file_metadata import FileMetadata
from halfphysics.motion.frame_numbers import check_index, check_slice
from halfphysics.motion.pose import Pose, checked, checked_axes, checked_scale, flat_rotations
from halfphysics.motion.possible import check_radians, check_speed
from halfphysics.motion.resampling import interpolated, neighbours, sample_positions
from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.formats.format import Assets

Array = NDArray[np.float64]

GENDERS = ("neutral", "male", "female")
MODELS = ("smplx", "smplh", "smpl")
# Frames skinned at once when a whole clip is looked at: bounds the memory.
_CHUNK = 64


@dataclass(frozen=True, eq=False)
class Motion(InNotebook, ReadOnly):
    """SMPL-X parameters of one person over T frames. ReadOnly: its arrays are read-only.

    The world is z-up. The pelvis is at ``axes @ J0(betas) + translation`` where J0 is the
    pelvis of the shaped body at rest: the SMPL family turns about the pelvis, not the origin.

    Args:
        translation: Of the SMPL-X origin [m], world, shape (T, 3), T >= 2.
        rotations: Axis-angle [rad] of the 55 joints (`JOINT_NAMES`) in their parents' frames,
            the pelvis in the world, shape (T, 55, 3) or (T, 165). Zero fingers: a flat hand.
        fps: Frames per second.
        betas: Shape components (n,), any number, or None where unknown.
        gender: "neutral", "male" or "female": of the model that `betas` belong to.
        model: "smplx", "smplh" or "smpl": the model that `betas` belong to.
        axes: World from file axes, shape (3, 3); None: the identity.
        origin: Further data of the file (set by loaders, used by writers).
        stiffness_scale: How much stiffer than `Settings.stiffness` the person holds each joint on
            the way to each frame, as a factor (T, 55): arms that carry are tensed
            (`halfphysics.adapt`). None: 1 everywhere. Motion files do not keep it, and baselines
            that run in MuJoCo have no stiffness to scale.
        holds: What the hands are to hold, where the motion was adapted to it (`halfphysics.adapt`).
        recorded: The motion as it was before that, frame by frame, which measures compare with;
            None: it was not adapted. Motion files keep neither, result files keep both.

    Raises:
        InputError: A wrong shape, NaN, fewer than two frames, an fps that is not positive, a
            root faster than 50 m/s, rotations in degrees, an unknown gender or model, or `holds`
            or `recorded` of other frames.
    """

    translation: Array
    rotations: Array
    fps: float
    betas: Array | None = None
    gender: str = "neutral"
    model: str = "smplx"
    axes: Array = field(default_factory=lambda: np.eye(3), repr=False)
    origin: FileMetadata | None = field(default=None, repr=False)
    stiffness_scale: Array | None = field(default=None, repr=False)
    holds: tuple[AdaptedHold, ...] = field(default=(), repr=False)
    recorded: Motion | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        translation = checked("translation", self.translation, (None, 3), "(T, 3)")
        rotations = checked(
            "rotations", flat_rotations(self.rotations, 1), (None, 55, 3), "(T, 55, 3) or (T, 165)"
        )
        frames = len(translation)
        if len(rotations) != frames:
            raise InputError(
                f"rotations: found {len(rotations)} frames but translation has {frames}; "
                "expected the same number"
            )
        if frames < 2:
            raise InputError(
                f"motion: found {frames} frame(s), expected at least 2: velocities need a next "
                "frame. Repeat the frame to hold a pose, or index with motion[i] for a Pose"
            )
        fps = frame_rate(self.fps)
        check_speed(translation, fps)
        check_radians(rotations)
        betas = self.betas
        if betas is not None:
            betas = checked("betas", betas, (None,), "a vector (n,)")
        for name, known in (("gender", GENDERS), ("model", MODELS)):
            its = getattr(self, name)
            if not isinstance(its, str) or its not in known:
                raise InputError(f"{name}: found {shown(its)}, expected one of {', '.join(known)}")
        if not isinstance(self.origin, FileMetadata | None):
            raise InputError(
                f"origin: found {shown(self.origin)}, expected None or the data of a file that "
                "was read"
            )
        for name, value in (
            ("translation", translation),
            ("rotations", rotations),
            ("fps", fps),
            ("betas", betas),
            ("axes", checked_axes(self.axes)),
            ("holds", _as_tuple(self.holds)),
        ):
            object.__setattr__(self, name, value)
        if self.stiffness_scale is not None:
            expected = f"({frames}, {N_JOINTS})"
            scale = checked_scale(self.stiffness_scale, (frames, N_JOINTS), expected)
            object.__setattr__(self, "stiffness_scale", scale)
        check_adaptation(self)

    def __repr__(self) -> str:
        shape = "no betas" if self.betas is None else f"{len(self.betas)} betas"
        return (
            f"Motion({len(self)} frames at {self.fps:g} fps, {self.duration:.2f} s, "
            f"{self.model} {self.gender}, {shape})"
        )

    # -- reading -------------------------------------------------------------------------

    @property
    def poses(self) -> Array:
        """All rotations in AMASS order (root, body, jaw, eyes, hands), shape (T, 165)."""
        return self.rotations.reshape(len(self), -1)

    @property
    def duration(self) -> float:
        """Time from the first frame to the last [s]."""
        return (len(self) - 1) / self.fps

    def __len__(self) -> int:
        return len(self.translation)

    @overload
    def __getitem__(self, index: int) -> Pose: ...
    @overload
    def __getitem__(self, index: slice) -> Motion: ...
    def __getitem__(self, index: int | slice) -> Pose | Motion:
        """A `Pose` for an integer, a `Motion` for a slice; a step keeps real time (fps / step)."""
        if isinstance(index, slice):
            check_slice(index)
            return self.changed(lambda motion: motion._taken(index))
        check_index(index)
        try:
            scale = None if self.stiffness_scale is None else self.stiffness_scale[index]
            return Pose(self.translation[index], self.rotations[index], self.axes, scale)
        except IndexError:
            raise IndexError(f"frame {index} of a motion with {len(self)} frames") from None

    # -- changing ------------------------------------------------------------------------

    def _taken(self, index: slice) -> Motion:
        """A slice; a step keeps real time."""
        step = 1 if index.step is None else abs(int(index.step))
        metadata = None if self.origin is None else self.origin.taken(index, len(self))
        scale = None if self.stiffness_scale is None else self.stiffness_scale[index]
        return self._replaced(
            self.translation[index],
            self.rotations[index],
            self.fps / max(step, 1),
            metadata,
            scale,
            self._holds_at(np.arange(len(self), dtype=np.float64)[index]),
        )

    def _holds_at(self, position: Array) -> tuple[AdaptedHold, ...]:
        """The holds in a motion of these fractional frames (T,)."""
        sampled = (hold.sampled(position) for hold in self.holds)
        return tuple(hold for hold in sampled if hold is not None)

    def _replaced(
        self,
        translation: ArrayLike,
        rotations: ArrayLike,
        fps: float,
        metadata: FileMetadata | None,
        stiffness_scale: Array | None = None,
        holds: tuple[AdaptedHold, ...] = (),
    ) -> Motion:
        return Motion(
            as_array(translation),
            as_array(rotations),
            fps,
            betas=self.betas,
            gender=self.gender,
            model=self.model,
            axes=self.axes,
            origin=metadata,
            stiffness_scale=stiffness_scale,
            holds=holds,
        )

    def bare(self) -> Motion:
        """The frames alone: without stiffness, what is to be held and what was recorded."""
        if not self.holds and self.recorded is None and self.stiffness_scale is None:
            return self
        return dataclasses.replace(self, holds=(), recorded=None, stiffness_scale=None)

    def changed(self, change: Callable[[Motion], Motion]) -> Motion:
        """What `change` makes of the motion, with what it makes of the motion as recorded."""
        if self.recorded is None:
            return change(self)
        made = change(dataclasses.replace(self, recorded=None))
        return dataclasses.replace(made, recorded=change(self.recorded))

    def with_frames(
        self, translation: ArrayLike, rotations: ArrayLike, fps: float | None = None
    ) -> Motion:
        """The same person and file conventions with other frames (world frame, as in `Motion`).

        Extra per-frame data of the file, `stiffness_scale`, `holds` and `recorded` are kept while
        the number of frames and fps stay.
        """
        fps = self.fps if fps is None else frame_rate(fps)
        metadata = self.origin
        translation = checked("translation", translation, (None, 3), "(T, 3)")
        if len(translation) == len(self) and fps == self.fps:
            kept = self.stiffness_scale, self.holds
            made = self._replaced(translation, rotations, fps, metadata, *kept)
            known = self.recorded is not None
            return dataclasses.replace(made, recorded=self.recorded) if known else made
        if metadata is not None:
            metadata = FileMetadata(format=metadata.format, fields=metadata.fields)
        return self._replaced(translation, rotations, fps, metadata)

    def resample(self, fps: float) -> Motion:
        """The motion at another frame rate: SLERP of rotations, linear translation.

        Starts at the first frame. Frames at times that both rates share are copied bit for
        bit, so 30 -> 60 -> 30 gives the same motion. Nothing is extrapolated: where the last
        frame does not fall on the new grid the clip ends at the last grid time before it.

        Raises:
            InputError: `fps` is not positive, over 10,000, or leaves fewer than two frames.
        """
        fps = frame_rate(fps, "60.0")
        position = sample_positions(len(self), self.fps, fps)
        return self.changed(lambda motion: motion._sampled(position, fps))

    def _sampled(self, position: Array, fps: float) -> Motion:
        """The motion at fractional frames (T,)."""
        translation, rotations = interpolated(self.translation, self.rotations, position)
        metadata = None if self.origin is None else self.origin.sampled(position)
        scale = self.stiffness_scale
        if scale is not None:
            low, high, weight = neighbours(position)
            scale = scale[low] + weight[:, None] * (scale[high] - scale[low])
        holds = self._holds_at(position)
        return self._replaced(translation, rotations, fps, metadata, scale, holds)

    def grounded(self, body: Body, z: float = 0.0, *, percentile: float = 0.0) -> Motion:
        """The motion moved along z so that its lowest skin vertex touches height `z` [m].

        By default this is the lowest vertex of the whole clip: then no frame is below a floor at
        `z`, and the floor changes nothing that the clip does not require. If single noisy frames
        would lift the rest, `percentile` takes that percentile of the lowest heights of all frames
        instead (50: the median frame).

        Raises:
            InputError: `body` is no body, or an impossible height or percentile.
        """
        validation.body(body, "vertices")
        z = number(z, "z", unit="m")
        percentile = number(percentile, "percentile", least=0.0, most=100.0)
        lowest = np.empty(len(self))
        for start in over(range(0, len(self), _CHUNK), "heights", "frame", size=_CHUNK):
            frames = range(start, min(start + _CHUNK, len(self)))
            lowest[start : frames.stop] = body.vertices(self, frames=frames)[..., 2].min(axis=1)
        up = np.array([0.0, 0.0, z - float(np.percentile(lowest, percentile))])
        return self.changed(lambda m: m.with_frames(m.translation + up, m.rotations))

    # -- the names of the smplx package ----------------------------------------------------

    @staticmethod
    def from_smplx(
        *,
        fps: float,
        global_orient: ArrayLike,
        transl: ArrayLike,
        body_pose: ArrayLike | None = None,
        jaw_pose: ArrayLike | None = None,
        leye_pose: ArrayLike | None = None,
        reye_pose: ArrayLike | None = None,
        left_hand_pose: ArrayLike | None = None,
        right_hand_pose: ArrayLike | None = None,
        betas: ArrayLike | None = None,
        expression: ArrayLike | None = None,
        gender: str = "neutral",
        model: str = "smplx",
        up: str = "z",
        hands_mean: ArrayLike | None = None,
    ) -> Motion:
        """A motion from the parameters of the `smplx` package.

        Args:
            fps: Frames per second.
            global_orient: Root rotations (T, 3); like all rotations here axis-angle [rad] with
                any batch dimensions in front, or matrices (T, J, 3, 3), of one joint also
                (T, 3, 3); torch tensors too.
            transl: Translations (T, 3) [m].
            body_pose: 21 joints, (T, 63), or SMPL's 23, (T, 69), whose rigid hands are dropped;
                as matrices (T, 21, 3, 3) or (T, 23, 3, 3).
            jaw_pose: (T, 3), as leye_pose and reye_pose; missing parts are zero.
            leye_pose: See jaw_pose.
            reye_pose: See jaw_pose.
            left_hand_pose: 15 joints, (T, 45); PCA coefficients are refused.
            right_hand_pose: As left_hand_pose.
            betas: Shape (n,), (1, n) or (T, n) with equal rows.
            expression: Ignored, with a warning where it is not zero: the face is not simulated.
            gender: As in `Motion`, as is `model`.
            model: See gender.
            up: The axis that is up in these parameters: "z", "y", "-y" (y down), "x", "-x", "-z".
            hands_mean: (90,) mean hand of the model, left then right, to add to the fingers
                where they were made with ``flat_hand_mean=False``.

        Raises:
            InputError: Shapes that do not fit together, and all that `Motion` refuses.
        """
        from halfphysics.motion.smplx_names import read_parameters

        return read_parameters(
            rotations={
                "global_orient": global_orient,
                "body_pose": body_pose,
                "jaw_pose": jaw_pose,
                "leye_pose": leye_pose,
                "reye_pose": reye_pose,
                "left_hand_pose": left_hand_pose,
                "right_hand_pose": right_hand_pose,
            },
            transl=transl,
            fps=fps,
            betas=betas,
            expression=expression,
            gender=gender,
            model=model,
            axes=axes_of(up),
            hands_mean=hands_mean,
        )

    def to_smplx(self) -> dict[str, Array]:
        """Parameters under the names of the `smplx` package, float64, in the file's own axes.

        ``global_orient (T,3) body_pose (T,63) jaw_pose leye_pose reye_pose (T,3)
        left_hand_pose right_hand_pose (T,45) transl (T,3)`` and ``betas (1,n)`` where known;
        fingers for ``flat_hand_mean=True``. For a motion that was y-up the parameters are
        turned back (pass ``up="y"`` to `from_smplx`).
        """
        from halfphysics.motion.smplx_names import write_parameters

        return write_parameters(self)

    def in_file_axes(self) -> tuple[Array, Array]:
        """Translation (T, 3) and rotations (T, 55, 3) turned back to the file's own axes."""
        if np.array_equal(self.axes, np.eye(3)):
            return self.translation.copy(), self.rotations.copy()
        return turned(self.translation, self.rotations, self.axes.T)

    def rebased(self, body: Body, up: str = "z") -> Motion:
        """The same movement of `body`, with the `translation` of a file whose up axis is `up`.

        `axes` are the axes in which the pelvis at rest J0 is added to `translation`: with other
        axes, the same position of the pelvis is another translation.

        Args:
            body: The body whose pelvis at rest is J0.
            up: As in `from_smplx`.
        """
        axes = axes_of(up)
        if np.array_equal(self.axes, axes):
            return self
        shift = (self.axes - axes) @ body.rest_joints[0]
        return self.changed(
            lambda m: dataclasses.replace(
                m, translation=m.translation + shift, axes=axes, origin=None
            )
        )

    # -- files -----------------------------------------------------------------------------

    @staticmethod
    def load(
        path: str | os.PathLike[str],
        fps: float | None = None,
        up: str | None = None,
        hands: str | None = None,
        model: str | os.PathLike[str] | None = None,
        *,
        gender: str | None = None,
        frames: tuple[int | None, int | None] | None = None,
        clip: str | None = None,
        assets: Assets = None,
        floor: float | Literal["lowest"] | None = None,
    ) -> Motion:
        """Read a motion file; the format is found by content.

        Args:
            path: The file, or the folder of a data set that comes as one.
            fps: Frames per second if the file does not state them (or states them wrongly); unsaid,
                the format's own rate, or 30 with a warning.
            up: "z", "y", "-y" (y is down), "x", "-x" or "-z": the axis that is up in the file.
                Unsaid, the one that the format prescribes, or the one along which the person
                stands, with a warning.
            hands: "flat" or "mean": the meaning of zero fingers, if the format does not define it;
                unsaid, flat with a warning.
            model: A body-model file, needed for mean hands; or "smplx", "smplh", "smpl" where
                the file does not name its model.
            gender: "neutral", "male" or "female" if the file does not state it.
            frames: Read only frames start <= i < stop, as in a slice.
            clip: Name of the clip, if the file holds several (`halfphysics.clips` lists them), or
                of the person, if it tracks several: unsaid, the one who is there longest.
            assets: Folders of the data set's other files (meshes, templates), searched before
                $HALFPHYSICS_MODELS and the file's own folder.
            floor: Height of the floor in the file [m], z up: it is put at z = 0. "lowest": the
                lowest skin of the default body in all frames is. None: heights are those of the
                file, with a warning where soles stay off z = 0.

        Warns:
            HalfPhysicsWarning: What was assumed, and what the content says against the format's
                rules: another axis up, another unit, joints that bend the wrong way.

        Raises:
            FileError: The file is missing, damaged, of an unknown format, or holds a value that
                is missing or impossible. The message names field, found, expected, way out.
            InputError: An option is impossible.
        """
        from halfphysics.formats import load_motion

        return load_motion(
            path,
            fps=fps,
            up=up,
            hands=hands,
            model=model,
            gender=gender,
            frames=frames,
            clip=clip,
            assets=assets,
            floor=floor,
        )

    def save(
        self, path: str | os.PathLike[str], format: str | None = None, *, body: Body | None = None
    ) -> None:
        """Write under the keys of the file it came from, else by suffix, else AMASS keys.

        Reading back gives equal arrays: the file's number types are kept where they hold the
        values exactly, otherwise float64 is written. The file appears whole or not at all.

        Args:
            path: Where to. The suffix chooses the format where it is not the origin's; .npz is
                AMASS for the motion's `model`.
            format: Name of another format to write (`halfphysics.formats.FORMATS`).
            body: The body that moves, needed by formats that hold its joints (BVH) and by a
                format with another up axis than the motion's file (`rebased`).

        Raises:
            FileError: The folder does not exist or cannot be written.
            InputError: An unknown format name, or `body` is missing.
        """
        from halfphysics.formats import save_motion

        save_motion(self, path, format=format, body=body)


def _as_tuple(holds: Iterable[AdaptedHold]) -> tuple[AdaptedHold, ...]:
    if not isinstance(holds, Iterable):
        raise InputError(f"holds: found {shown(holds)}, expected a tuple of AdaptedHold")
    return tuple(holds)
