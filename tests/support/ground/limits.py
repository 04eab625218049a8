"""What each figure of `campaigns.ground` has to be, and the tables of rows."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

#: Return to the path: this long, and one second per metre of offset at the last obstacle [s].
RETURN = 3.0


@dataclass(frozen=True)
class Limit:
    """A figure's bounds, its short name, the kinds of cases and the things it is for, or not."""

    figure: str
    short: str
    most: float
    least: float = -float("inf")
    kinds: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    but: tuple[str, ...] = ()

    def applies(self, row) -> bool:
        if self.kinds and row["kind"] not in self.kinds:
            return False
        if row["what"] in self.but:
            return False
        return not self.only or row["what"] in self.only

    def holds(self, row) -> bool | None:
        """None: not measured, or not for this row."""
        value = row.get(self.figure)
        if value is None or not self.applies(row):
            return None
        return self.least <= value <= self.most

    def misses(self, row) -> float | None:
        """By how much the bounds are missed; 0 within them, None: not measured."""
        value = row.get(self.figure)
        if value is None or not self.applies(row):
            return None
        return max(0.0, value - self.most, self.least - value)


ENDS = ("scenario", "room", "sunk", "long")
FIRST = ("sunk",)
#: Fly on purpose: these stories ask for `weight=False`, and are run with the default settings here.
FLIES = ("fly_with_ball",)
LIMITS = (
    Limit("end_mm", "end mm", 5.0, -5.0, ENDS, but=FLIES),
    Limit("unsupported_percent", "unsup %", 5.0, but=FLIES),
    Limit("slide_mm", "slide", 2.0),
    Limit("slide_more_mm", "more", 0.2),
    Limit("range_deg", "range", 2.0),
    Limit("sustained_bw", "held BW", 2.0),
    Limit("peak_n", "peak N", 3000.0),
    Limit("first_bw", "first BW", 1.5, kinds=FIRST),
    Limit("toes_deg", "toes", 10.0, kinds=FIRST),
    Limit("knee_jerk", "knees", 1.5, kinds=FIRST),
    Limit("end_tilt_deg", "tilt", 2.0, kinds=("long",)),
    Limit("back_late_s", "late s", 0.0, kinds=("long",)),
    Limit("push_mean_n", "push N", 400.0, only=("wall",)),
    Limit("push_mean_n", "push N", 300.0, only=("jamb",)),
    Limit("push_peak_n", "push peak", 604.0, only=("box20", "box80", "box200")),
    Limit("pushed_mm", "pushed", float("inf"), 500.0, only=("box20",)),
    Limit("pushed_mm", "pushed", 10.0, only=("box200",)),
    Limit("wait_slide_mm", "wait", 0.3, only=("wall",)),
    Limit("free_mm", "free mm", 1e-6),
    Limit("breaches", "breach", 0.0),
    Limit("lost_s", "lost s", 0.0),
)
#: Figures that the table shows without a limit.
SHOWN = (("float_percent", "float %"), ("float_mm", "float mm"))


def late(row) -> float | None:
    """How much later than allowed the person is back on the path [s]; None: not known yet."""
    if row.get("last_hit_s") is None:
        return None
    allowed = RETURN + 0.001 * row["hit_offset_mm"]
    if row["back_s"] is not None:
        return row["back_s"] - allowed
    return row["back_left_s"] - allowed if row["back_left_s"] > allowed else None


def failed(row) -> list[str]:
    """The figures of a row that miss their limits."""
    return [limit.figure for limit in LIMITS if limit.holds(row) is False]


def comparison(before, after) -> str:
    """By how much limits are missed in two logs, case by case.

    In how many cases by less, in how many by more, the means over all cases, and the chance of so
    uneven a split among coin tosses (two-sided sign test).
    """
    old = {(row["id"], row["person"]): row for row in before}
    pairs = [(old[key], row) for row in after if (key := (row["id"], row["person"])) in old]
    lines = [f"{f'{len(pairs)} cases':32s}" + "".join(f"{h:>14s}" for h in _COMPARED)]
    for limit in LIMITS:
        found = [(limit.misses(a), limit.misses(b)) for a, b in pairs if limit.holds(a) is not None]
        found = [(a, b) for a, b in found if b is not None]
        better, worse = sum(b < a for a, b in found), sum(b > a for a, b in found)
        if not better + worse:
            continue
        means = [sum(values) / len(found) for values in zip(*found, strict=True)]
        chance = min(1.0, 2.0 * _tail(max(better, worse), better + worse))
        cells = (str(better), str(worse), f"{means[0]:.4g}", f"{means[1]:.4g}", f"{chance:.2g}")
        lines.append(f"{limit.short:32s}" + "".join(f"{cell:>14s}" for cell in cells))
    return "\n".join(lines)


_COMPARED = ("better", "worse", "missed by", "now", "by chance")


def _tail(at_least, tosses) -> float:
    """The chance of at least so many heads."""
    return sum(comb(tosses, k) for k in range(at_least, tosses + 1)) / 2**tosses


def table(rows) -> str:
    """One line per row: figures, those that miss their limit with a star."""
    limits = {}
    for limit in LIMITS:
        limits.setdefault(limit.figure, []).append(limit)
    head = [(name, its[0].short) for name, its in limits.items()]
    head[1:1] = SHOWN
    lines = [f"{'':44s}" + "".join(f"{short:>10s}" for _, short in head)]
    for row in rows:
        cells = []
        for name, _ in head:
            value = row.get(name)
            verdicts = [limit.holds(row) for limit in limits.get(name, ())]
            shown = "-" if value is None else f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
            cells.append(f"{shown + ('*' if False in verdicts else ''):>10s}")
        name = row["id"] + (f"/{row['person']}" if row["person"] else "")
        lines.append(f"{name:44s}" + "".join(cells))
    return "\n".join(lines)


def summary(rows) -> str:
    """How many rows keep each limit, by kind of case."""
    kinds = sorted({row["kind"] for row in rows})
    lines = [f"{'kept / measured':32s}" + "".join(f"{kind:>14s}" for kind in (*kinds, "all"))]
    for limit in LIMITS:
        bounds = f"<= {limit.most:g}" if limit.most < float("inf") else f">= {limit.least:g}"
        only = f" ({limit.only[0]})" if limit.only else ""
        cells = []
        for kind in (*kinds, None):
            found = [limit.holds(r) for r in rows if kind is None or r["kind"] == kind]
            found = [verdict for verdict in found if verdict is not None]
            cells.append(f"{sum(found)}/{len(found)}" if found else "-")
        name = f"{limit.short} {bounds}{only}"
        lines.append(f"{name:32s}" + "".join(f"{cell:>14s}" for cell in cells))
    cells = []
    for kind in (*kinds, None):
        found = [not failed(r) for r in rows if kind is None or r["kind"] == kind]
        cells.append(f"{sum(found)}/{len(found)}")
    lines.append(f"{'rows with all':32s}" + "".join(f"{cell:>14s}" for cell in cells))
    return "\n".join(lines)
