"""The measures that `judge` takes: name, unit, which way is better, definition and source of each.

The function that computes a measure has its full definition; `Measure.function` names it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

#: What a measure needs beside the motion.
Need = Literal["", "scene", "truth", "things", "things and truth"]

#: What is missing, in words, by need.
WANTED: Mapping[str, str] = MappingProxyType(
    {
        "scene": "takes a scene",
        "truth": "takes a truth",
        "things": "takes a scene with more in it than planes",
        "things and truth": "takes a truth, and a scene with more in it than planes",
    }
)


@dataclass(frozen=True, kw_only=True)
class Measure:
    """One measure.

    Attributes:
        key: Its name in files and in `Verdict.values`.
        name: The name that its source gives it.
        unit: Unit; "" for a ratio or yes (1) and no (0).
        better: Whether less or more of it is better.
        definition: What it is, in one line.
        source: Whose it is; "ours" for those of this project.
        function: The function that computes it, below `halfphysics.metrics`.
        needs: What it takes beside the motion.
        least: Fewest frames that it takes.
    """

    key: str
    name: str
    unit: str
    better: Literal["lower", "higher"]
    definition: str
    source: str
    function: str
    needs: Need = ""
    least: int = 2

    @property
    def label(self) -> str:
        """Name and unit, such as "FS [mm]"."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def _of(*fields: str, needs: Need = "", least: int = 2, higher: bool = False) -> Measure:
    key, name, unit, definition, source, function = fields
    return Measure(
        key=key,
        name=name,
        unit=unit,
        better="higher" if higher else "lower",
        definition=definition,
        source=source,
        function=function,
        needs=needs,
        least=least,
    )


_PHYSDIFF = "PhysDiff (Yuan et al. 2023)"
_KIMODO = "Kimodo (NVIDIA 2026)"
_IPMAN = "IPMAN (Tripathi et al. 2023)"
_EMDB = "EMDB (Kaufmann et al. 2023), as WHAM evaluates it"
_CHOIS = "CHOIS (Li et al. 2024), InterAct"
_PSI = "PSI (Zhang et al. 2020), POSA (Hassan et al. 2021)"

# fmt: off
#: Every measure, in the order of tables.
MEASURES: tuple[Measure, ...] = (
    _of("penetrate_mm", "Penetrate", "mm",
        "mean depth of the lowest vertex under the ground, up to 5 mm as 0",
        _PHYSDIFF, "physdiff"),
    _of("float_mm", "Float", "mm",
        "mean height of the lowest vertex above the ground, up to 5 mm as 0",
        _PHYSDIFF, "physdiff"),
    _of("skate_mm", "Skate", "mm/frame",
        "mean horizontal step of balls of feet under 5 cm in both frames",
        _PHYSDIFF, "foot_skate"),
    _of("phys_err_mm", "Phys-Err", "mm", "sum of Penetrate, Float and Skate",
        _PHYSDIFF, "physdiff"),
    _of("gmd_skating_ratio", "skating ratio", "",
        "share of steps in which a toe under 5 cm in both frames is faster than 0.5 m/s, and on "
        "average over 5 steps",
        "GMD (Karunratanakul et al. 2023), its code", "gmd_skating_ratio"),
    _of("kimodo_skate_height", "FootSkateFromHeight", "m/s",
        "mean speed of toes under 5 cm", _KIMODO, "foot_skate_from_height"),
    _of("kimodo_skate_ratio", "FootSkateRatio", "",
        "of steps of a toe under 5 cm at both ends, the share over 0.2 m/s",
        _KIMODO, "foot_skate_ratio"),
    _of("kimodo_skate_contacts", "FootSkateFromContacts", "m/s",
        "mean speed of ankles and toes where the truth has contact (under 10 cm and 0.15 m/s)",
        _KIMODO, "foot_skate_from_contacts", needs="truth"),
    _of("kimodo_consistency", "FootContactConsistency", "",
        "share of the truth's contact labels that the motion has as well",
        _KIMODO, "foot_contact_consistency", needs="truth", higher=True),
    _of("foot_sliding_mm", "FS", "mm",
        "horizontal steps of ankles under H = 8 cm and toes under 4 cm times 2 - 2^(h/H), over T",
        "EgoEgo (Li et al. 2023), OMOMO, CHOIS", "foot_sliding_mm"),
    _of("jitter", "jitter", "10 m/s^3", "mean third difference of 22 joints, times fps^3",
        _EMDB, "jitter", least=4),
    _of("jerk", "jerk", "m/s^3", "the same of 55 joints, in m/s^3",
        "TransPose (Yi et al. 2021); ours", "jerk", least=4),
    _of("stability_error_mm", "stability error", "mm",
        "mean horizontal distance of centre of mass and centre of pressure, frames in contact",
        _IPMAN, "stability"),
    _of("bose_percent", "BoSE", "%",
        "share of frames with the centre of mass above the hull of the skin under 10 cm",
        _IPMAN, "stability", higher=True),
    _of("self_penetration_percent", "self-penetration", "%",
        "mean share of vertices inside another segment of the body, 20 frames of a clip",
        "winding numbers as TUCH (Mueller et al. 2021)", "self_penetration"),
    _of("self_penetration_mm", "self-penetration, depth", "mm",
        "mean over these frames of the deepest of them", "ours", "self_penetration"),
    _of("non_collision_percent", "non-collision", "%",
        "mean share of vertices with a signed distance over 0 from the scene",
        _PSI, "scene_contact", needs="scene", higher=True),
    _of("non_collision_coins_percent", "non-collision (COINS)", "%",
        "the same with a signed distance of 0 or more",
        "COINS (Zhao et al. 2022)", "scene_contact", needs="scene", higher=True),
    _of("scene_contact_percent", "contact", "%",
        "share of frames in which a vertex has a signed distance under 0",
        f"{_PSI}, COINS", "scene_contact", needs="scene", higher=True),
    _of("penetration_rate_percent", "penetration rate", "%",
        "mean share of vertices inside the scene", "ours", "penetration", needs="scene"),
    _of("depth_mean_mm", "Depth_mean", "mm", "mean over frames of the deepest vertex",
        "ours", "penetration", needs="scene"),
    _of("depth_max_mm", "Depth_max", "mm", "deepest vertex of the clip",
        "ours", "penetration", needs="scene"),
    _of("floating_percent", "floating", "%",
        "share of the frames outside of jumps with no skin within 5 mm of what can carry it",
        "ours", "floating", needs="scene"),
    _of("hand_contact_percent", "C%", "%", "share of frames with a hand under 5 cm from a thing",
        _CHOIS, "contact_scores", needs="things", higher=True),
    _of("contact_precision", "contact precision", "",
        "of the frames with a hand under 5 cm from a thing, the share that truly have",
        _CHOIS, "contact_scores", needs="things and truth", higher=True),
    _of("contact_recall", "contact recall", "", "of the frames that truly have, the share found",
        _CHOIS, "contact_scores", needs="things and truth", higher=True),
    _of("contact_f1", "contact F1", "", "harmonic mean of the two",
        _CHOIS, "contact_scores", needs="things and truth", higher=True),
    _of("mpjpe_mm", "MPJPE", "mm", "mean error of 55 joints relative to the pelvis",
        "ours", "mpjpe", needs="truth"),
    _of("mpjpe_global_mm", "MPJPE-g", "mm", "mean error of 55 joints in the world",
        "ours", "mpjpe_global", needs="truth"),
    _of("acceleration_error", "Accel", "m/s^2",
        "mean error of the accelerations of 22 joints relative to the middle of the hips",
        "HMMR (Kanazawa et al. 2019), as WHAM", "acceleration_error", needs="truth", least=3),
    _of("wa_mpjpe_mm", "WA-MPJPE_100", "mm",
        "mean error of 22 joints, pieces of 100 frames aligned to the truth whole",
        _EMDB, "wa_mpjpe", needs="truth"),
    _of("w_mpjpe_mm", "W-MPJPE_100", "mm", "the same, aligned by the first two frames of a piece",
        _EMDB, "w_mpjpe", needs="truth"),
    _of("rte_percent", "RTE", "%",
        "mean error of the root, path rigidly aligned, over the length of the true path",
        _EMDB, "rte", needs="truth"),
    _of("world_foot_sliding_mm", "foot sliding", "mm",
        "mean step of toe and heel vertices whose true step is under 1 cm",
        _EMDB, "world_foot_sliding", needs="truth"),
    _of("phc_success", "success (PHC)", "", "1 if the mean joint error is never over 0.5 m, else 0",
        "PHC (Luo et al. 2023)", "phc_success", needs="truth", higher=True),
)
# fmt: on

#: Key -> measure.
BY_KEY: Mapping[str, Measure] = MappingProxyType({measure.key: measure for measure in MEASURES})
