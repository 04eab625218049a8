"""Contact labels in the layouts of other data sets, as further files of a sample."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from halfphysics.base.npz_bytes import npz_bytes

if TYPE_CHECKING:
    from halfphysics.labels import ContactLabels


def other_labels(labels: ContactLabels, names: Iterable[str]) -> dict[str, bytes]:
    """``contact.NAME.npz`` for each data set named: contact of the first person with the first
    object; further pairs are numbered as ``human.npz`` and ``object.npz`` are, person first, as in
    ``contact.behave.1-0.npz``. A single array is called ``contact``.

    Args:
        labels: Labels from `contact_labels`.
        names: Names of data sets, from `outputs.ALSO`.
    """
    from halfphysics.labels import exporters

    files = {}
    for name in names:
        export = getattr(exporters, name)
        for person in range(len(labels.people)):
            for item in range(len(labels.objects)):
                found = export(labels, person=person, item=item)
                fields = found if isinstance(found, dict) else {"contact": found}
                which = f".{person}-{item}" if person or item else ""
                files[f"contact.{name}{which}.npz"] = npz_bytes(fields)
    return files
