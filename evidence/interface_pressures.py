"""Pressures between people and what they lie or sit on, as published.

Each number is what its source says, in the source's unit; ranges are its means with one standard
deviation to both sides, or the smallest and the largest of its means. Mats of sensors differ from
each other by tens of per cent, and read the lowest pressures (under 5 mmHg, `SHOWN` of
`halfphysics.results.layer_pressure`; Yuan et al.: 0.67 kPa) as zero.
"""

from __future__ import annotations

from dataclasses import dataclass

#: Pascals of a millimetre of mercury.
MMHG = 133.322
#: Pressure above which Yuan et al. call contact "middle to high" [Pa].
MIDDLE = 4000.0

MATTRESSES = (
    "Interface pressures of new and worn standard and viscoelastic hospital mattresses, Wound "
    "Management & Prevention 66(8):26-31, 2020, doi 10.25270/wmp.2020.8.2631"
)
SURGICAL = (
    "Influence of support surfaces on the distribution of body interface pressure in surgical "
    "positioning, Rev Lat-Am Enfermagem 26:e3083, 2018, doi 10.1590/1518-8345.2692.3083"
)
HEELS = (
    "Thompson-Bishop and Mottola, Tissue interface pressure and estimated subcutaneous pressures "
    "of 11 different pressure-reducing support surfaces, Decubitus 5(2):42-48, 1992"
)
CURVED = (
    "Curvilinear supine position of 145 healthy volunteers on a surgical table, J Wound Ostomy "
    "Continence Nursing (nursingcenter.com, article 4323051)"
)
YOUTH = (
    "Body pressure of the back of 106 healthy youths in bed, J Japanese Society of Nursing "
    "Research 10 (transducers of 8 cm)"
)
SEATS = (
    "Li, Chen, Tseng and Tsai, Biomechanical analysis of different dynamic sitting techniques, "
    "BioMedical Engineering OnLine 18:4, 2019, doi 10.1186/s12938-018-0621-2 (15 people of 65 kg, "
    "a firm seat with 1 cm of foam)"
)
CHAIRS = (
    "Yuan et al., A novel bamboo sheet chair and its influence on sitting comfort, PeerJ 8:e9476, "
    "2020, doi 10.7717/peerj.9476 (25 people)"
)
LOADS = (
    "Mbada et al., Biomechanical effect of sitting postures on sitting load and feet weight, "
    "Clinical Health Sciences 16(1):15-21, 2016, doi 10.4103/1596-4078.190030 (210 people)"
)


@dataclass(frozen=True, kw_only=True)
class Published:
    """A measure of a posture, from `low` to `high` in `unit`: its source, and how it is derived."""

    posture: str
    measure: str
    unit: str
    low: float
    high: float
    source: str
    how: str


def _kpa(mmhg: float) -> float:
    return round(mmhg * MMHG / 1000.0, 2)


#: Of people who lie on their back on a mattress, and sit on a seat with their feet on the floor.
TABLE: tuple[Published, ...] = (
    Published(
        posture="lying",
        measure="mean pressure",
        unit="kPa",
        low=_kpa(18.0),
        high=_kpa(38.37 + 7.43),
        source=f"{MATTRESSES}; {CURVED}",
        how="means of five mattresses 30.3 to 38.4 mmHg, the highest with its SD of 7.4; below, "
        "60 kg over the 2,439 cm^2 of the surgical table (18 mmHg)",
    ),
    Published(
        posture="lying",
        measure="area",
        unit="cm^2",
        low=1500.0,
        high=3400.0,
        source=f"{CURVED}; {MATTRESSES}",
        how="2,439 and 2,710 cm^2 on a table with a thin pad, and up to a quarter more on a "
        "mattress, which they sink into; least: 70 kg over the highest mean pressure above",
    ),
    Published(
        posture="lying",
        measure="peak of the pelvis",
        unit="kPa",
        low=_kpa(30.0),
        high=_kpa(100.0),
        source=f"{SURGICAL}; {YOUTH}",
        how="sacrum: means of 30 (transducer of 8 cm) and 42.9 mmHg; single cells of the mats over "
        "80 mmHg, and about 100 mmHg with the back raised",
    ),
    Published(
        posture="lying",
        measure="peak of the heels",
        unit="kPa",
        low=_kpa(15.35),
        high=_kpa(93.9),
        source=f"{SURGICAL}; {HEELS}",
        how="means of 15.4 mmHg, 28.1 to 62.1 on soft surfaces, 93.9 on a standard mattress",
    ),
    Published(
        posture="lying",
        measure="peak of the upper back",
        unit="kPa",
        low=_kpa(20.0),
        high=_kpa(60.0),
        source=f"{YOUTH}; {MATTRESSES}",
        how="scapula: 20 mmHg, mean of a transducer of 8 cm; most cells of the mats under 60 mmHg",
    ),
    Published(
        posture="sitting",
        measure="share of the weight on seat and rest",
        unit="%",
        low=69.0,
        high=81.0,
        source=LOADS,
        how="44.9 of 64.5 kg, ischial, to 51.9 of 64.5, sacroischial; the rest on the feet",
    ),
    Published(
        posture="sitting",
        measure="mean pressure of the seat",
        unit="kPa",
        low=3.47,
        high=8.11,
        source=SEATS,
        how="mean of the seat's front (thighs), and of its back (buttocks)",
    ),
    Published(
        posture="sitting",
        measure="peak of the seat",
        unit="kPa",
        low=6.55,
        high=41.28,
        source=SEATS,
        how="of foam: over the peak under the thighs, under that of the buttocks on a firm seat",
    ),
    Published(
        posture="sitting",
        measure="area of the seat",
        unit="cm^2",
        low=680.0,
        high=1300.0,
        source=SEATS,
        how="front and back of a firm seat 843 to 869 cm^2, SD up to 159; foam up to half more",
    ),
    Published(
        posture="sitting",
        measure="area of the seat over 4 kPa",
        unit="cm^2",
        low=217.0,
        high=493.0,
        source=CHAIRS,
        how="308 (SD 90) of a flexible shell and 394 (SD 99) of a padded office chair",
    ),
)


def rows(posture: str) -> tuple[Published, ...]:
    """What is published about a posture."""
    return tuple(row for row in TABLE if row.posture == posture)
