"""All numbers of a result as one digest: equal where results are, to the last bit."""

import hashlib

import numpy as np


def bits(result):
    """All numbers of a result, as one digest."""
    digest = hashlib.sha256()
    arrays = [result.clearance, result.lost_time, *result.diagnostics.values()]
    for person in result.people:
        arrays += [person.motion.translation, person.motion.rotations, person.torque]
    for track in result.objects.values():
        arrays += [track.position, track.quaternion]
    arrays += [*result.joints.values()]
    for table in (result.contacts, result.inside):
        arrays += [getattr(table, column) for column in table.columns()]
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
