"""Limits of the figures of a carry, and tables of rows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """A figure of a row, its short name, and the range in which it should be."""

    figure: str
    short: str
    most: float = float("inf")
    least: float = float("-inf")

    def holds(self, row) -> bool | None:
        """Whether a row keeps it; None: the figure is undefined."""
        value = row.get(self.figure)
        return None if value is None else self.least <= value <= self.most


#: A person holds a suitcase with 100 to 200 N a hand; a wrist that has moved by over 5 cm, or a
#: trunk by over 1 cm, is another motion than the recorded one.
LIMITS = (
    Limit("lifted", "lifted", least=1.0),
    Limit("carried_share", "carried", least=1.0),
    Limit("away_mm", "away mm", 100.0),
    Limit("away_deg", "away deg", 15.0),
    Limit("released_s", "release", 0.4, -0.2),
    Limit("early_mm", "early mm", 2.0),
    Limit("pushed_mm", "pushed mm", 20.0),
    Limit("slip_mm", "slip mm", 20.0),
    Limit("opposition", "oppose", least=0.5),
    Limit("peak_n", "peak N", 300.0),
    Limit("end_mm", "end mm", 100.0),
    Limit("hands_mm", "hands mm", 50.0),
    Limit("elsewhere_mm", "else mm", 10.0),
    Limit("jerk_ratio", "jerk", 1.5),
    Limit("untouched_equal", "same", least=1.0),
    Limit("breaches", "breach", 0.0),
    Limit("size_mm", "size mm", 5.0),
)


def failed(row, limits=LIMITS) -> list[str]:
    """The figures of a row that miss their limits."""
    return [limit.figure for limit in limits if limit.holds(row) is False]


def held(row) -> bool:
    """Lifted, carried and not released early."""
    return not {"lifted", "carried_share", "released_s"} & set(failed(row))


def table(rows, limits=LIMITS) -> str:
    """One line per row: figures, those that miss their limit with a star."""
    lines = [f"{'':52s}" + "".join(f"{limit.short:>10s}" for limit in limits)]
    for row in rows:
        cells = []
        for limit in limits:
            value = row.get(limit.figure)
            shown = "-" if value is None else f"{float(value):.3g}"
            if value is not None and abs(value) >= 1000.0:
                shown = f"{value:.0f}"
            cells.append(f"{shown + ('*' if limit.holds(row) is False else ''):>10s}")
        lines.append(f"{row['id']:52s}" + "".join(cells))
    return "\n".join(lines)


def summary(rows) -> str:
    """How many rows keep each limit: by how many hands hold, by noise, and of all."""
    groups = {
        "two hands": lambda row: row["hands"] == 2,
        "one hand": lambda row: row["hands"] == 1,
        **{n: lambda row, n=n: row["noise"] == n for n in ("none", "gap", "aside", "inside")},
        "all": lambda row: True,
    }
    named = {row.get("layout", "memory") for row in rows}
    if len(named) > 1:
        groups |= {n: lambda row, n=n: row.get("layout", "memory") == n for n in sorted(named)}
    lines = [f"{'kept / measured':24s}" + "".join(f"{name:>12s}" for name in groups)]
    for limit in LIMITS:
        bounds = f"<= {limit.most:g}" if limit.most < float("inf") else f">= {limit.least:g}"
        cells = []
        for within in groups.values():
            found = [limit.holds(row) for row in rows if within(row)]
            found = [verdict for verdict in found if verdict is not None]
            cells.append(f"{sum(found)}/{len(found)}" if found else "-")
        lines.append(f"{f'{limit.short} {bounds}':24s}" + "".join(f"{c:>12s}" for c in cells))
    for name, kept in (("held", held), ("rows with all", lambda row: not failed(row))):
        cells = []
        for within in groups.values():
            found = [kept(row) for row in rows if within(row)]
            cells.append(f"{sum(found)}/{len(found)}" if found else "-")
        lines.append(f"{name:24s}" + "".join(f"{c:>12s}" for c in cells))
    return "\n".join(lines)


def comparison(before, after) -> str:
    """Of the cases in both logs: how many keep each limit before and now, won and lost."""
    old = {row["id"]: row for row in before}
    pairs = [(old[row["id"]], row) for row in after if row["id"] in old]
    lines = [f"{f'{len(pairs)} cases':24s}" + "".join(f"{h:>10s}" for h in _COMPARED)]
    for limit in LIMITS:
        found = [(limit.holds(a), limit.holds(b)) for a, b in pairs]
        cells = (
            sum(a is True for a, _ in found),
            sum(b is True for _, b in found),
            sum(b is True and a is not True for a, b in found),
            sum(a is True and b is not True for a, b in found),
        )
        lines.append(f"{limit.short:24s}" + "".join(f"{cell:>10d}" for cell in cells))
    return "\n".join(lines)


_COMPARED = ("before", "now", "won", "lost")
