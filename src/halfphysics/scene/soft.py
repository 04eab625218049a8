"""Soft: a compliant layer on a shape, over a hard frame that nothing enters.

A layer is a foundation of independent springs (Winkler): where it is pressed in by d [m], it
presses back with p = k d + c d' >= 0 [Pa]. The shape that a user gives is the visible, unloaded
surface; the hard frame lies `thickness` below it (`halfphysics.scene.soft_frame`). docs/soft.md has
the laws.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from halfphysics.base.field_checks import FieldChecks
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.scene.soft_materials import MATERIALS

#: Damping time c/k where none is given [s]: a loss factor of 0.13 at 2 Hz, as seat foam has.
DAMPING_TIME = 0.01
#: Thinnest layer [m]: twice the default `Settings.clearance`, at which hard things already meet.
LEAST_THICKNESS = 0.002
#: Thickest layer [m]: a landing pit of foam.
MOST_THICKNESS = 2.0
#: Softest and stiffest layer [Pa/m]: a quilt; a rubber mat of 1 mm, beyond which nothing is felt.
LEAST_STIFFNESS, MOST_STIFFNESS = 1e2, 1e10
#: Largest damping time c/k [s], and the slowest recovery [s].
MOST_TIME, SLOWEST_RECOVERY = 10.0, 3600.0
#: Fields that the law "linear" does not have.
_OF_FOAM = ("densification", "hysteresis", "recovery")
#: What a layer without a damping of its own is made with: it gets one by its stiffness.
_BY_STIFFNESS: Any = None


@dataclass(frozen=True)
class Soft:
    """A soft layer. Raises `InputError` if impossible.

    Attributes:
        thickness: From the surface to the hard frame [m].
        stiffness: Pressure per depth at small depths, k [Pa/m]: modulus over thickness.
        damping: Pressure per speed of indentation, c [Pa s/m]; not given, or None: 0.01 s times
            the stiffness.
        law: "linear": p = k d + c d' down to the frame. "foam": stiffens towards full compression,
            and gives back less than it took: p = k d (1 + densification (d/thickness)^4) + c d',
            and beside it a spring that slackens.
        densification: Of "foam": see `law`.
        hysteresis: Of "foam": stiffness of the spring that slackens, as a share of `stiffness`.
        recovery: Of "foam": the time in which it does, and in which the surface comes back [s].
    """

    thickness: float
    stiffness: float
    damping: float = _BY_STIFFNESS
    law: Literal["foam", "linear"] = "foam"
    densification: float = 1.5
    hysteresis: float = 0.3
    recovery: float = 0.5

    def __post_init__(self) -> None:
        check = FieldChecks(self)
        check.plain()
        check.number(
            "thickness",
            least=LEAST_THICKNESS,
            most=MOST_THICKNESS,
            why=" [m], from the surface to the hard frame",
        )
        check.number(
            "stiffness",
            least=LEAST_STIFFNESS,
            most=MOST_STIFFNESS,
            why=" [Pa/m], the modulus of the foam over its thickness (seat foam of 0.1 m: 1.9e5)",
        )
        if self.damping is _BY_STIFFNESS:
            object.__setattr__(self, "damping", DAMPING_TIME * self.stiffness)
        check.number(
            "damping",
            least=0.0,
            most=MOST_TIME * self.stiffness,
            why=f" [Pa s/m], which is {MOST_TIME:g} s times the stiffness",
        )
        check.choice("law", "foam", "linear")
        check.number("densification", least=0.0, most=1000.0)
        check.number("hysteresis", least=0.0, most=100.0)
        check.number("recovery", least=1e-3, most=SLOWEST_RECOVERY, why=" [s]")

    @staticmethod
    def named(name: str, *, thickness: float | None = None) -> Soft:
        """The layer of a material by its name, such as "sofa".

        Args:
            name: Of `halfphysics.scene.soft_materials.MATERIALS`.
            thickness: Of the layer [m]; None: as usual for it. Stiffness is modulus over thickness.

        Raises:
            InputError: There is none of this name, or an impossible thickness.
        """
        material = MATERIALS.get(name) if isinstance(name, str) else None
        if material is None:
            hint = did_you_mean(name, MATERIALS, form=repr, otherwise=".")
            raise InputError(
                f"soft: there is no material called {shown(name)}{hint} There are: "
                f"{', '.join(MATERIALS)}; or give halfphysics.Soft(thickness, stiffness)"
            )
        thick = material.thickness
        if thickness is not None:
            thick = number(
                thickness,
                f"soft {name!r}: thickness",
                least=LEAST_THICKNESS,
                most=MOST_THICKNESS,
                unit="m",
            )
        stiffness = material.modulus / thick
        return Soft(
            thickness=thick,
            stiffness=stiffness,
            damping=material.damping_time * stiffness,
            law="foam",
            densification=material.densification,
            hysteresis=material.hysteresis,
            recovery=material.recovery,
        )

    def of_thickness(self, thickness: float) -> Soft:
        """A layer of the same foam with another thickness [m]: its modulus stays."""
        factor = self.thickness / thickness
        return replace(
            self,
            thickness=thickness,
            stiffness=factor * self.stiffness,
            damping=factor * self.damping,
        )

    @property
    def document(self) -> dict[str, Any]:
        """The fields as plain data, for files: those of "foam" only where the law has them."""
        names = [field.name for field in fields(self)]
        return {n: getattr(self, n) for n in names if self.law == "foam" or n not in _OF_FOAM}


def checked_soft(what: str, given: Any) -> Soft | None:
    """What a caller gave as `soft`: a layer, the name of a material, its fields, or None.

    Args:
        what: Begins the messages.
        given: A `Soft`, a name, a mapping of the fields of `Soft`, or None.

    Raises:
        InputError: Something else, an unknown name or field, an impossible value.
    """
    if given is None or isinstance(given, Soft):
        return given
    try:
        if isinstance(given, str):
            return Soft.named(given)
        if isinstance(given, Mapping):
            return _of_fields(given)
    except InputError as error:
        raise InputError(f"{what}: {error}") from None
    raise InputError(
        f"{what}: soft: found {shown(given)}, expected halfphysics.Soft(thickness, stiffness) or "
        f"one of {', '.join(map(repr, MATERIALS))}"
    )


def _of_fields(given: Mapping[str, Any]) -> Soft:
    """A layer from its fields; with "material", those of it that are not given."""
    known = ("material", *(field.name for field in fields(Soft)))
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known, form=repr, otherwise=".")
            raise InputError(
                f"soft: unknown field {shown(name)}{hint} There are: {', '.join(known)}"
            )
    values = dict(given)
    if "material" in values:
        base = Soft.named(values.pop("material"), thickness=values.pop("thickness", None))
        return replace(base, **values)
    for name in ("thickness", "stiffness"):
        if name not in values:
            raise InputError(
                f"soft: found no {name}, expected thickness [m] and stiffness [Pa/m], or a material"
            )
    return Soft(**values)
