"""What programs put around all names of a skeleton: a prefix ("Robot_Hips"), a number ("Hips_01").

Axis Studio has a prefix, Sketchfab numbers the nodes, Blender those that it has a second time.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

#: Part of the names that have it, where it is not the joints' own: roots and tips may lack it.
_MOST = 0.75
_NUMBER = re.compile(r"[._ -]\d{1,5}$")
_END_OF_PREFIX = re.compile(r"[:|._ -]")
# A prefix has at most this many letters: names from strangers may have any length.
_LONGEST = 64


def without_affixes(names: Sequence[str]) -> list[str]:
    """The names without the prefix and without the number that most of them have."""
    enough = _MOST * len(names)
    bare = list(names)
    if sum(_NUMBER.search(name) is not None for name in bare) >= enough:
        bare = [_NUMBER.sub("", name) or name for name in bare]
    prefixes = Counter(
        name[: match.end()]
        for name in bare
        for match in _END_OF_PREFIX.finditer(name, 0, _LONGEST)
        if match.end() < len(name)
    )
    shared = [prefix for prefix, count in prefixes.items() if count >= enough]
    if shared:
        longest = max(shared, key=len)
        bare = [name.removeprefix(longest) or name for name in bare]
    return bare
