"""Soft skin: how thick and how stiff the tissue of each part is, and the core beneath it.

The skin of a `Body` is its unloaded surface; what nothing enters lies the tissue's thickness below.
Only the tissue that gives way counts: a fingertip's pulp, a palm's pad, fat and slack muscle of the
seat, not the whole way to the bone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.field_checks import FieldChecks
from halfphysics.errors import InputError
from halfphysics.geometry.inset import Inset, inset
from halfphysics.motion.joint_groups import JointValues, joint_values
from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Thickness that gives way [m]. Each value is ours, of the order that abstracts report. Over the
#: ischial tuberosity 74 +- 9 mm of tissue lose nearly half by sitting (Makhsous et al. 2011, Clin
#: Anat 24), and 6 to 32 mm are left on foam (Sonenblum et al. 2020, J Tissue Viability 29): 20 mm
#: for all of the seat. Heel pads are 16 mm thick ("Effect of loading history on material properties
#: of human heel pad", BMC Musculoskelet Disord 2022), of which a third. Fingers, hands and the rest
#: are not measured ones: fat and skin.
THICKNESS: JointValues = JointValues(
    {
        "all": 0.006,
        "pelvis": 0.020,
        "left_hip": 0.018,
        "right_hip": 0.018,
        "trunk": 0.010,
        "head": 0.003,
        "hands": 0.003,
        "fingers": 0.002,
        "feet": 0.005,
    }
)
#: Modulus: pressure per share of that thickness [Pa], of small loads. Under a load of 1 N gluteal
#: fat has 26 +- 19 kPa, under 5 N muscle 62 +- 10 kPa; under 30 N both are far stiffer, 2200 and
#: 440 kPa (Isogai et al. 2022, J Phys Ther Sci 34): what is stiff then belongs to the hard core.
#: Heel pads of an unloaded foot have 6.0 +- 1.5 N/mm ("Initial studies on the variations of
#: load-displacement curves of in vivo human healthy heel pads"), on some 4 cm^2: 75 kPa at 5 mm.
#: Others are ours: between them; skin over bone more.
MODULUS: JointValues = JointValues(
    {
        "all": 60e3,
        "pelvis": 40e3,
        "left_hip": 40e3,
        "right_hip": 40e3,
        "trunk": 50e3,
        "head": 200e3,
        "feet": 75e3,
        "hands": 100e3,
        "fingers": 100e3,
    }
)
#: Damping over stiffness, c/k [s]: heel pads lose 33 to 48 % of the energy of a load (Ker 1996, J
#: Exp Biol 199), or 62 % (Challis et al. 2008, J Appl Biomech 24); loads of walking last some 20 ms
#: while they rise. The same order in other tissue.
DAMPING_TIME = 0.005
#: Limits of what can be asked for: thickness [m] and modulus [Pa].
MOST_THICKNESS, LEAST_MODULUS, MOST_MODULUS = 0.05, 1e3, 1e9
#: Thinnest layer of skin [m]: under it, a part is hard.
LEAST = 1e-4


@dataclass(frozen=True, kw_only=True)
class SoftSkin:
    """Soft tissue by part. Raises `InputError` if impossible.

    Attributes:
        thickness: Of the tissue that gives way [m], per joint group or joint; what is not named is
            as usual; 0: hard.
        modulus: Pressure per share of the thickness [Pa], likewise.
        damping_time: Damping over stiffness [s].
    """

    thickness: Mapping[str, float] | None = None
    modulus: Mapping[str, float] | None = None
    damping_time: float = DAMPING_TIME

    def __post_init__(self) -> None:
        for name, most in (("thickness", MOST_THICKNESS), ("modulus", MOST_MODULUS)):
            given = getattr(self, name)
            if given is None:
                continue
            values = joint_values(given, f"SoftSkin.{name}", extra=("pelvis",))
            least = LEAST_MODULUS if name == "modulus" else 0.0
            for key, value in values.items():
                if not least <= value <= most:
                    raise InputError(
                        f"SoftSkin.{name}[{key!r}]: expected {least:g} to {most:g} "
                        f"[{'Pa' if least else 'm'}], found {value:g}"
                    )
            object.__setattr__(self, name, values)
        check = FieldChecks(self)
        check.plain()
        check.number("damping_time", least=0.0, most=1.0, why=" [s]")

    @property
    def document(self) -> dict[str, Any]:
        """The fields that differ from the usual, as plain data, for files."""
        given = {"thickness": self.thickness, "modulus": self.modulus}
        found: dict[str, Any] = {k: dict(v) for k, v in given.items() if v is not None}
        return found | {"damping_time": self.damping_time}

    def by_part(self) -> tuple[Array, Array]:
        """Thickness (55,) [m] and modulus (55,) [Pa] of every part."""
        return _resolved(THICKNESS, self.thickness), _resolved(MODULUS, self.modulus)


def _resolved(usual: JointValues, given: Mapping[str, float] | None) -> Array:
    """The usual numbers (55,), with those that were given in their place."""
    result = usual.resolve(dict(usual)["all"])
    if given is not None:
        changed = JointValues(given).resolve(np.nan)
        result = np.where(np.isnan(changed), result, changed)
    return result


def checked_soft_skin(value: object) -> bool | SoftSkin:
    """`Settings.soft_skin` as it is kept: False, True or a `SoftSkin`.

    A mapping of the fields of `SoftSkin` is one, as files have it.

    Raises:
        InputError: Anything else.
    """
    if isinstance(value, bool | SoftSkin):
        return value
    if isinstance(value, Mapping):
        known = ("thickness", "modulus", "damping_time")
        unknown = [key for key in value if key not in known]
        if unknown:
            raise InputError(
                f"Settings.soft_skin: found {unknown}, expected some of {', '.join(known)}"
            )
        return SoftSkin(**value)
    raise InputError(
        f"Settings.soft_skin is {value!r}; expected True, False or a "
        "halfphysics.body.soft_skin.SoftSkin"
    )


_known: WeakKeyDictionary[Body, dict[bytes, Inset]] = WeakKeyDictionary()


def soft_core(body: Body, skin: SoftSkin) -> Inset:
    """The hard core of a body at rest: vertices (V, 3) [m], rest frame, thickness above (V,) [m].

    The thickness of a vertex blends those of its parts, by its weights. Made once per body.
    """
    by_part = skin.by_part()[0]
    known = _known.setdefault(body, {})
    key = by_part.tobytes()
    if key not in known:
        wanted = body.weights @ by_part[:N_JOINTS]
        faces = np.ascontiguousarray(body.faces, dtype=np.int32)
        used = np.unique(faces)
        number = np.zeros(len(wanted), dtype=np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        made = inset(body.rest_vertices[used], number[faces], np.maximum(wanted[used], LEAST))
        vertices, thickness = np.array(body.rest_vertices), np.zeros(len(wanted))
        vertices[used], thickness[used] = made.vertices, made.thickness
        hard = wanted < LEAST
        vertices[hard], thickness[hard] = body.rest_vertices[hard], 0.0
        known[key] = Inset(vertices, thickness)
    return known[key]
