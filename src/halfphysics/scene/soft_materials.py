"""Soft materials by name, with values and their sources.

Foam is sold by its indentation force (ILD, IFD): what a disc of 323 cm^2 needs to sink 25 % into
100 mm of it, read after 60 s. The modulus here is that force over the disc's area and 0.25, so that
a layer of 100 mm carries what the test says, the foam's pull beside the disc included. One pound of
ILD makes 551 Pa.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

#: Area of the disc of the indentation test [m^2], and the share of the thickness it sinks.
DISC, SHARE = 0.0323, 0.25
#: Newtons of a pound-force.
POUND = 4.44822


def of_indentation(pounds: float) -> float:
    """Modulus [Pa] of foam by its indentation force at 25 % (ILD) [lbf]."""
    return POUND * pounds / (DISC * SHARE)


@dataclass(frozen=True, kw_only=True)
class SoftMaterial:
    """A foam.

    Attributes:
        modulus: Pressure per share of the thickness, of slow small depths [Pa]: stiffness times
            thickness.
        thickness: Usual thickness of its layer [m].
        damping_time: Damping over stiffness, c/k [s].
        hysteresis: Stiffness that slackens under load, as a share of the one that stays.
        recovery: Time in which that happens, and in which the foam comes back [s].
        densification: How much it stiffens: pressure at full compression is 1 + this many times
            that of a spring. 1.5: 65 % takes 3.3 times the pressure of 25 %.
        source: Where the values come from.
    """

    modulus: float
    thickness: float
    damping_time: float
    hysteresis: float
    recovery: float
    densification: float
    source: str


_TEST = (
    "The test: ASTM D3574 B1 (https://en.wikipedia.org/wiki/Indentation_force-deflection). "
    "ILD 25 % of seats and mattresses 25 to 40 lbf, at 65 % 1.8 to 3.5 times that, rebound 40 to "
    "70 %: Bedding Magazine, Foam Primer (https://www.futonlife.com/content/primer-foam)."
)

#: Name -> material.
MATERIALS: Mapping[str, SoftMaterial] = MappingProxyType(
    {
        "sofa": SoftMaterial(
            modulus=of_indentation(35.0),
            thickness=0.12,
            damping_time=0.01,
            hysteresis=0.35,
            recovery=0.5,
            densification=1.5,
            source=f"Seat cushion of polyurethane foam, ILD 35 lbf. {_TEST}",
        ),
        "mattress": SoftMaterial(
            modulus=of_indentation(28.0),
            thickness=0.18,
            damping_time=0.01,
            hysteresis=0.3,
            recovery=0.5,
            densification=1.5,
            source=f"Mattress core of polyurethane foam, ILD 28 lbf. {_TEST}",
        ),
        "pillow": SoftMaterial(
            modulus=of_indentation(10.0),
            thickness=0.12,
            damping_time=0.05,
            hysteresis=1.0,
            recovery=4.0,
            densification=1.5,
            source=(
                "Slow-recovery (viscoelastic) foam, ILD 10 lbf: a hand's print is left behind and "
                "goes within seconds "
                "(https://www.coreconcepts.com.sg/article/memory-foam-pillows-the-basics/). "
                f"{_TEST}"
            ),
        ),
        "mat": SoftMaterial(
            modulus=30e3,
            thickness=0.10,
            damping_time=0.015,
            hysteresis=0.5,
            recovery=0.2,
            densification=3.0,
            source=(
                "Gymnastics landing mat: of a 24 kg impactor's impacts the abstract of Pain, Mills "
                "and Yeadon (Video analysis of the deformation and effective mass of gymnastics "
                "landing mats, Med Sci Sports Exerc 2005) gives depths of 0.088 to 0.118 m, "
                "volumes of 0.030 to 0.044 m^3, and 481 to 930 N on the mat's own mass, up to 12 % "
                "of the peak force. Peaks are taken as these over 0.12, 4.0 to 7.8 kN: over the "
                "volume 1.3e5 to 1.8e5 Pa/m, in mats of 0.2 m, as competitions have, 27 to 35 kPa. "
                "Thickness: of the mat that is put on top of these (https://doi.org/10.1177/"
                "17543371221140495). Hysteresis, recovery and densification are ours."
            ),
        ),
    }
)
