"""Load what a sweep made, from WebDataset shards: in PyTorch loaders, or with numpy alone.

python examples/05_load_a_sweep_webdataset.py FOLDER     (that `halfphysics sweep` wrote)
"""

import sys
from pathlib import Path

import numpy as np

import halfphysics.sweep


def load(folder):
    """Samples for a training loop: pip install webdataset. It goes into a DataLoader as it is."""
    import webdataset

    shards = sorted(str(path) for path in Path(folder).glob("shards/*/*.tar"))
    samples = webdataset.WebDataset(shards, shardshuffle=False, empty_check=False).decode()
    for sample in samples:
        card, human = sample["card.json"], sample["human.npz"]
        yield card["factors"], human["poses"], human["trans"], sample["contact.npz"]


def main(folder):
    """Prints the samples, read in both ways; returns how many there are."""
    count = 0
    plain = halfphysics.sweep.read(folder, parts=("card", "human"))
    for (factors, poses, _, contact), sample in zip(load(folder), plain, strict=True):
        assert np.array_equal(poses, sample["human"]["poses"])
        said = ", ".join(f"{name} {value}" for name, value in factors.items())
        touched = int(np.count_nonzero(contact["human_parts"].any(axis=0)))
        print(f"{sample['key']}: {said}; {len(poses)} frames, {touched} parts touched something")
        count += 1
    return count


if __name__ == "__main__":
    main(sys.argv[1])
