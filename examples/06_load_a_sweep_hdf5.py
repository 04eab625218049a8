"""Load what a sweep made, from HDF5 shards (outputs: formats: [hdf5] in the sweep file).

python examples/06_load_a_sweep_hdf5.py FOLDER     (that `halfphysics sweep` wrote)
"""

import json
import sys
from pathlib import Path

import numpy as np


def load(folder):
    """Samples in order: pip install h5py. Only what is used is read from the disk."""
    import h5py

    for path in sorted(Path(folder).glob("shards/*/*.h5")):
        with h5py.File(path) as shard:
            for sample in shard.values():
                factors = json.loads(sample.attrs["card"])["factors"]
                human, contact = sample["human"], sample["contact"]
                yield factors, human["poses"][:], human["trans"][:], contact["human_parts"][:]


def main(folder):
    """Prints how far people went and what they touched with; returns how many there are."""
    count = 0
    for factors, poses, trans, parts in load(folder):
        said = ", ".join(f"{name} {value}" for name, value in factors.items())
        far = np.linalg.norm(np.diff(trans, axis=0), axis=1).sum()
        touched = int(np.count_nonzero(parts.any(axis=0)))
        print(f"{said}: {far:.2f} m in {len(poses)} frames, {touched} parts touched something")
        count += 1
    return count


if __name__ == "__main__":
    main(sys.argv[1])
