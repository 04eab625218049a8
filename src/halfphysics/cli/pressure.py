"""halfphysics pressure: maps of what presses on soft things and on skins."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number
from halfphysics.cli.options import check_output
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.results.result import Result

EXAMPLES = """\
halfphysics pressure result.npz -o map.png
halfphysics pressure result.npz -o sofa.mp4 --of sofa --side top
halfphysics pressure result.npz -o map.png --frame -1 --cell 2 --most 12
halfphysics pressure result.npz -o skin.png --skin
halfphysics pressure result.npz -o skin.npz --skin --of person1"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Write a pressure map of a result: a picture (.png), a film (.mp4, .webm, .gif) or arrays
    (.npz).

    Of a thing it is a grid over one side [kPa] with a scale in cm, of a person's skin front and
    back of the body. A picture without --frame has the largest pressure of every place over time.
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RESULT")]
    """A result of `simulate` with something soft in it."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FILE")]
    """The file to write."""
    of: str | None = None
    """The soft thing, or with --skin the person; without it the thing that is pressed most, or the
    first person."""
    skin: bool = False
    """Of a person's skin."""
    side: str | None = None
    """Of a thing: top, bottom, front, back, left or right, in its own axes; without it the side
    that carries most."""
    cell: float = 1.0
    """Of a thing: side of a cell of the grid [cm]."""
    frame: int | None = None
    """Of a picture: the frame to show, negative ones from the end."""
    most: float | None = None
    """Pressure at the end of the colours [kPa]; without it the largest, rounded up."""

    def run(self) -> None:
        """Write the map."""
        from halfphysics.formats.results.result_file import is_result
        from halfphysics.results.result import Result

        check_output(self.out, self.file)
        if not is_result(self.file):
            raise InputError(
                f"{self.file}: found no result, expected one of halfphysics simulate or scenario "
                "with something soft in it"
            )
        if self.skin and (self.side is not None or self.cell != 1.0):
            raise InputError("--skin: --side and --cell are of a thing's map; leave them out")
        number(self.cell, "--cell", least=0.1, most=100.0, unit="cm")
        result = Result.load(self.file)
        if self.skin:
            self._skin(result)
        else:
            self._thing(result)
        print(f"pressure: {self.out}")

    @property
    def _pascals(self) -> float | None:
        return None if self.most is None else 1e3 * self.most

    def _thing(self, result: Result) -> None:
        from halfphysics.render.pressure_pictures import save_pressure
        from halfphysics.results.pressure_maps import pressure_map

        try:
            made = pressure_map(result, self.of, side=self.side, cell=0.01 * self.cell)
        except InputError as error:
            # Here a cell is in cm.
            said = str(error).replace("cell: found", "--cell: found", 1)
            here, there = f"{0.01 * self.cell:g} m", f"{self.cell:g} cm"
            raise InputError(said.replace(here, there, 1)) from None
        save_pressure(made, self.out, frame=self.frame, most=self._pascals)
        largest = 1e-3 * float(made.pressure.max(initial=0.0))
        force = float(made.force.max(initial=0.0))
        print(f"{made.name}, {made.side}: up to {largest:.1f} kPa, {force:.0f} N")
        if made.missed > 0.05:
            print(f"{100.0 * made.missed:.0f} % of the force is on other sides; --side shows them")

    def _skin(self, result: Result) -> None:
        from halfphysics.render.skin_pictures import save_skin_pressure

        names = [person.name for person in result.people]
        if self.of is not None and self.of not in names:
            hint = did_you_mean(self.of, names, otherwise=".")
            raise InputError(
                f"--of: found {self.of!r}{hint} With --skin it is a person: {', '.join(names)}"
            )
        index = 0 if self.of is None else names.index(self.of)
        save_skin_pressure(result, self.out, person=index, frame=self.frame, most=self._pascals)
