"""Encoding of pictures as a film: MP4 (H.264) and WebM (VP9) by ffmpeg, GIF by Pillow."""

from __future__ import annotations

import contextlib
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError, InputError, MissingDependencyError

Picture = NDArray[np.uint8]
Write = Callable[[Picture], None]

# The number of threads is fixed because the bytes depend on it.
_THREADS = ("-threads", "4")
_H264 = (
    *("-c:v", "libx264", "-preset", "medium", "-crf", "19", *_THREADS),
    *("-movflags", "+faststart", "-f", "mp4"),
)
_VP9 = (
    *("-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-row-mt", "1", "-cpu-used", "4"),
    *("-deadline", "good", *_THREADS, "-f", "webm"),
)
_FFMPEG = {".mp4": _H264, ".webm": _VP9}
# For playback in every browser: yuv420p, colours as BT.709, with tags.
_COLORS = (
    "-vf",
    "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,"
    "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=bt709",
)
_SAME_BYTES = ("-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact")

#: Suffixes of films.
FILMS = (*_FFMPEG, ".gif")
#: Largest frame rate of a GIF: viewers slow down faster ones [1/s].
GIF_FPS = 50.0
_GIF_COLORS = 255


def check_film(suffix: str, size: tuple[int, int], fps: float) -> None:
    """Refuse a film that cannot be encoded; called before rendering.

    Raises:
        InputError: A size or frame rate that the format does not support.
        MissingDependencyError: ffmpeg is not installed.
    """
    if suffix == ".gif":
        if fps > GIF_FPS:
            raise InputError(
                f"fps: found {fps:g}, but a GIF shows at most {GIF_FPS:g} frames per second"
            )
        return
    if size[0] % 2 or size[1] % 2:
        even = "x".join(str(side + side % 2) for side in size)
        raise InputError(
            f"size: found {size[0]}x{size[1]}, but a {suffix} film needs even numbers. Try {even}"
        )
    ffmpeg(suffix)


def ffmpeg(suffix: str) -> str:
    """Path of the ffmpeg program.

    Raises:
        MissingDependencyError: It is neither in the package imageio-ffmpeg nor on the path.
    """
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # RuntimeError: a package without the program
        program = shutil.which("ffmpeg")
    if program is None:
        raise MissingDependencyError(
            f"a {suffix} film needs ffmpeg, which is not installed. pip install "
            "'halfphysics[film]' brings it (package imageio-ffmpeg), or install ffmpeg itself; "
            ".gif and .png need neither"
        )
    return program


@contextlib.contextmanager
def encoder(path: Path, suffix: str, size: tuple[int, int], fps: float) -> Iterator[Write]:
    """A sink for the pictures, in order; the film is complete when the block ends.

    Args:
        path: The file to write; the caller makes the write atomic.
        suffix: .mp4 or .webm.
        size: Width and height [pixels].
        fps: Frames per second.

    Raises:
        FileError: ffmpeg cannot write the film (missing codec, no space left).
        MissingDependencyError: ffmpeg is not installed.
    """
    command = [
        *(ffmpeg(suffix), "-hide_banner", "-loglevel", "error", "-nostdin", "-y"),
        *("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}"),
        *("-r", f"{fps:.6f}", "-i", "pipe:0", "-an", *_COLORS),
        *(*_FFMPEG[suffix], *_SAME_BYTES, str(path)),
    ]
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said, stderr=said)
        pipe: IO[bytes] = process.stdin  # type: ignore[assignment]
        broken = False
        try:
            try:
                yield lambda picture: _give(pipe, picture)
                pipe.close()
            except BrokenPipeError:  # ffmpeg ended early: its output has the reason
                broken = True
            failed = process.wait() != 0 or broken
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        if failed:
            said.seek(0)
            words = said.read().decode(errors="replace").strip().splitlines()
            raise FileError(f"ffmpeg cannot write the film: {_reason(words, path)}")


def _give(pipe: IO[bytes], picture: Picture) -> None:
    pipe.write(np.ascontiguousarray(picture).data)


def _reason(words: list[str], path: Path) -> str:
    """The error of ffmpeg, in one line."""
    known = ("No space left on device", "File too large", "Unknown encoder", "Input/output error")
    told = [line for line in words if any(reason in line for reason in known)] or words[-1:]
    if not told:
        return "it says nothing"
    # Remove the prefix with ffmpeg's component: "[out#0/mp4 @ 0x55d0] ".
    return re.sub(r"^\[[^\]]*\] ", "", told[0]).replace(str(path), path.name)


def save_gif(
    file: IO[bytes], pictures: Iterable[Picture], samples: Iterable[Picture], fps: float
) -> None:
    """Writes a GIF that repeats for ever.

    Args:
        file: The file to write.
        pictures: The pictures, in order.
        samples: Some of the pictures, for the palette of all.
        fps: Frames per second; times are rounded to 1/100 s, without accumulated error.
    """
    from PIL import Image

    # An octree keeps small bright areas (the ghost), which a median cut mixes with the rest.
    all_of_them = Image.fromarray(np.concatenate(list(samples)))
    colors = all_of_them.quantize(_GIF_COLORS, method=Image.Quantize.FASTOCTREE)
    frames: list[Any] = []
    for picture in pictures:
        frames.append(Image.fromarray(picture).quantize(palette=colors, dither=Image.Dither.NONE))
    ends = [round(100 * (k + 1) / fps) for k in range(len(frames))]
    lasting = [10 * (end - start) for start, end in zip([0, *ends], ends, strict=False)]
    frames[0].save(
        file, format="GIF", save_all=True, append_images=frames[1:], duration=lasting, loop=0
    )
