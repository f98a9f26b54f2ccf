"""Images in a row as a gif, webp or mp4, in a file or inline in a notebook.

Gif and webp are written by Pillow, of the extra [plot]; mp4 by the program ffmpeg, where it is installed or the package
imageio-ffmpeg brings it.
"""

from __future__ import annotations

import base64
import io
import shutil
import subprocess
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_count
from nonsmooth.checks.files import ANIMATION_ENDINGS, as_place, whole_file
from nonsmooth.errors import FileFailure, InvalidInput, MissingExtra

MAX_FPS = 100  # defined: frames a second: a gif says their length in hundredths of a second
COLOURS = 128  # chosen: of a gif's palette: shades of bodies, lines and letters, taken from three of its frames
# chosen: of an mp4: a quality at which lines stay clean, and what every player reads
MP4 = ("-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4")
EVEN = "pad=ceil(iw/2)*2:ceil(ih/2)*2"  # defined: H.264 with these colours has even widths and heights

Frame = Callable[[int], np.ndarray]  # the image (height, width, 3) of a record


@dataclass(frozen=True, repr=False)
class Animation:
    """An animation that a notebook shows inline."""

    data: bytes  # a gif

    def _repr_html_(self) -> str:
        text = base64.b64encode(self.data).decode()
        return f'<img alt="the motion" style="max-width:100%" src="data:image/gif;base64,{text}">'

    def __repr__(self) -> str:
        return f"Animation({len(self.data) / 1e6:.2g} MB): shown in a notebook; give a path to write it"


def as_animation(path: str | Path | None, fps: int) -> tuple[Path | None, int]:
    """The path and the frames a second of an animation, checked; None is one for a notebook."""
    fps = as_count("fps", fps)
    if fps > MAX_FPS:
        raise InvalidInput(f"fps must not exceed {MAX_FPS}, the fastest that a gif shows; got {fps}")
    if path is None:
        return None, fps
    path = as_place("path", path, ANIMATION_ENDINGS)
    if path.suffix == ".mp4":
        find_ffmpeg()
    return path, fps


def find_ffmpeg() -> str:
    """The program, or `MissingExtra`."""
    program = shutil.which("ffmpeg")
    if program is not None:
        return program
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise MissingExtra(
            "an .mp4 is written by ffmpeg, which is not installed; install it (Debian's package ffmpeg, or "
            "pip install imageio-ffmpeg), or write a .gif or .webp"
        ) from None


def animation(path: Path | None, fps: int, shown: np.ndarray, frame: Frame) -> Path | Animation:
    """Draw these records one after the other: into a file, or for a notebook."""
    if path is None:
        image = io.BytesIO()
        write_images(image, "gif", fps, shown, frame)
        return Animation(image.getvalue())
    with whole_file(path) as part:
        if path.suffix == ".mp4":
            write_mp4(part, fps, shown, frame)
        else:
            write_images(part, path.suffix[1:], fps, shown, frame)
    return path


def write_images(target: Any, kind: str, fps: int, shown: np.ndarray, frame: Frame) -> None:
    """A gif or a webp: lines and letters in few colours, the same in each frame."""
    try:
        from PIL import Image
    except ImportError:
        raise MissingExtra('animations need Pillow; install it with pip install "nonsmooth[plot]"') from None
    some = [frame(shown[k]) for k in (0, len(shown) // 2, -1)]
    palette = Image.fromarray(np.concatenate(some)).quantize(COLOURS, Image.Quantize.FASTOCTREE)
    frames = (Image.fromarray(frame(k)).quantize(palette=palette, dither=Image.Dither.NONE) for k in shown)
    duration = round(1000 / fps)
    next(frames).save(target, kind, save_all=True, append_images=frames, duration=duration, loop=0)


def write_mp4(target: Path, fps: int, shown: np.ndarray, frame: Frame) -> None:
    """An mp4: the images are handed to ffmpeg as they are drawn."""
    height, width = frame(shown[0]).shape[:2]
    images = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps), "-i", "-")
    command = [find_ffmpeg(), "-y", "-loglevel", "error", *images, "-vf", EVEN, *MP4, str(target)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as ffmpeg:
        assert ffmpeg.stdin is not None and ffmpeg.stderr is not None
        with suppress(BrokenPipeError):  # it ended, and says why
            for k in shown:
                ffmpeg.stdin.write(np.ascontiguousarray(frame(k)).tobytes())
        with suppress(BrokenPipeError):
            ffmpeg.stdin.close()
        said = ffmpeg.stderr.read().decode(errors="replace").strip()
    if said or ffmpeg.returncode:
        raise FileFailure(f"ffmpeg could not write the animation: {said.splitlines()[-1] if said else 'no reason'}")
