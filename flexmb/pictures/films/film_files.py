"""Files of films: GIF by Pillow, MP4 by the ffmpeg that comes with imageio-ffmpeg."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks

if TYPE_CHECKING:
    from flexmb.pictures.films.film_frames import Film

PALETTE_FRAMES = 8
"""Number of frames from which the colours of a GIF are chosen."""

QUALITY = 8
"""Quality of an MP4 file, 0 to 10."""


def write_gif(path: Path, film: Film, fps: float) -> None:
    """Write a film as a GIF that is repeated for ever.

    All frames have one palette, so that only the changed part of a frame is stored.  Times in a GIF are hundredths of a
    second; they are rounded so that the film as a whole has its length.
    """
    from PIL import Image

    chosen = np.unique(np.linspace(0, len(film) - 1, min(len(film), PALETTE_FRAMES)).round().astype(int))
    strip = Image.fromarray(np.concatenate(list(film.frames(chosen.tolist())), axis=0))
    palette = strip.quantize(colors=255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in film.frames()]
    colours, paper = images[0].getpalette() or [], int(np.asarray(images[0])[-1, 0])
    colours[3 * paper : 3 * paper + 3] = [255, 255, 255]  # the paper is white, not nearly so
    for image in images:
        image.putpalette(colours)
    ends = np.round(100.0 * np.arange(len(images) + 1) / fps)
    pauses = [10 * max(int(pause), 1) for pause in np.diff(ends)]
    images[0].save(path, "GIF", save_all=True, append_images=images[1:], duration=pauses, loop=0, optimize=False)


def write_mp4(path: Path, film: Film, fps: float) -> None:
    """Write a film as an MP4 file (H.264), with even numbers of pixels.

    A film that ffmpeg could not write whole raises `OSError`, since ffmpeg raises no error of its own.
    """
    ffmpeg = checks.package("imageio_ffmpeg", "film", "An .mp4 film")
    wide, high = film.size
    even = (wide + wide % 2, high + high % 2)
    writer = ffmpeg.write_frames(
        str(path), even, fps=fps, codec="libx264", quality=QUALITY, macro_block_size=1, ffmpeg_log_level="error"
    )
    writer.send(None)
    try:
        for frame in film.frames():
            added = ((0, even[1] - high), (0, even[0] - wide), (0, 0))
            writer.send(np.ascontiguousarray(np.pad(frame, added, mode="edge")))
        writer.close()
        written = ffmpeg.count_frames_and_secs(str(path))[0]
    except (OSError, RuntimeError) as error:  # OSError: ffmpeg has ended; RuntimeError: its file is no film
        raise OSError("ffmpeg failed; is the disk full?") from error
    finally:
        writer.close()
    if written != len(film):
        raise OSError(f"ffmpeg wrote {written} of {len(film)} frames; is the disk full?")
