"""Clients that only watch, many of them in one process of their own.

PYTHONPATH=src:tests python -m support.live.watchers URL COUNT SECONDS
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from websockets.asyncio.client import connect

import halfphysics
from halfphysics.live import schema

_PATH = f"{Path(halfphysics.__file__).parents[1]}:{Path(__file__).parents[2]}"


def watchers(url: str, count: int, seconds: float) -> subprocess.Popen:
    """Watchers in another process; its output is a line of `figures`."""
    command = [sys.executable, "-m", "support.live.watchers", url, str(count), str(seconds)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, env={"PYTHONPATH": _PATH})


def figures(process: subprocess.Popen) -> dict[str, float]:
    """What they saw: frames, frames/s of each, and how old frames were (p50, p99) [s]."""
    return json.loads(process.communicate()[0])


async def _watch(url: str, ends: float, ages: list[float]) -> int:
    frames = 0
    protocols = [schema.MSGPACK_PROTOCOL]
    async with connect(url, subprotocols=protocols, compression=None, max_size=None) as live:
        await live.recv()
        while time.perf_counter() < ends:
            data = await live.recv()
            now = time.perf_counter()
            frames += 1
            if frames % 10 == 1:  # decoding all of them would be what is measured
                message = schema.from_server(data)
                if isinstance(message, schema.FrameMessage):
                    ages.append(now - message.clock)
    return frames


async def _main(url: str, count: int, seconds: float) -> None:
    ages: list[float] = []
    ends = time.perf_counter() + seconds
    frames = await asyncio.gather(*(_watch(url, ends, ages) for _ in range(count)))
    p50, p99 = np.percentile(ages, [50, 99])
    found = {"frames": sum(frames), "rate": sum(frames) / count / seconds, "p50": p50, "p99": p99}
    print(json.dumps(found))


if __name__ == "__main__":
    asyncio.run(_main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
