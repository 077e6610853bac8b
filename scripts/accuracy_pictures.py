# SPDX-License-Identifier: Apache-2.0
"""Pictures of a sweep of accuracy: how far one is from its reference.

PSNR is of the 8 bits of sRGB that are in the file.  FLIP is that of Andersson et al. ("FLIP: A
Difference Evaluator for Alternating Images", 2020) at 67 pixels a degree, by NVIDIA's
flip-evaluator.
"""

from pathlib import Path

import numpy as np
from PIL import Image

PIXELS_A_DEGREE = 67.0


def load(path: Path) -> np.ndarray:
    """The grey bytes of a picture, [height, width]; packs the file as small as PNG goes."""
    with Image.open(path) as picture:
        grey = picture.convert("L")
        if picture.mode != "L":
            save(path, grey)
    return np.asarray(grey)


def save(path: Path, picture: Image.Image) -> None:
    part = path.with_suffix(".part")
    picture.save(part, "PNG", optimize=True)
    part.replace(path)


def psnr(reference: np.ndarray, picture: np.ndarray) -> float | None:
    """In dB; None when the pictures are the same."""
    square = np.mean((reference.astype(float) - picture.astype(float)) ** 2)
    return None if square == 0 else float(10 * np.log10(255**2 / square))


def flip_of(reference: np.ndarray, picture: np.ndarray) -> tuple[float, np.ndarray]:
    """The mean FLIP error, 0 to 1, and that of each pixel as bytes."""
    if np.array_equal(reference, picture):
        return 0.0, np.zeros_like(reference)
    import flip_evaluator

    def colours(grey):
        return np.repeat((grey.astype(np.float32) / 255)[:, :, None], 3, axis=2)

    errors, mean, _ = flip_evaluator.evaluate(
        colours(reference),
        colours(picture),
        "LDR",
        applyMagma=False,
        parameters={"ppd": PIXELS_A_DEGREE},
    )
    return float(mean), np.rint(255 * errors[:, :, 0]).astype(np.uint8)


def compare(out: Path, folder: Path, file: str) -> dict:
    """The figures of a picture in a folder of `out` beside `reference.png`.

    Writes a map of FLIP errors, too.  Names of files are those below `out`.
    """
    reference, picture = load(out / folder / "reference.png"), load(out / folder / file)
    mean, errors = flip_of(reference, picture)
    differences = file.replace(".png", "-flip.png")
    save(out / folder / differences, Image.fromarray(errors))
    return {
        "width": reference.shape[1],
        "height": reference.shape[0],
        "psnr_db": psnr(reference, picture),
        "flip": mean,
        "file": str(folder / file),
        "flip_file": str(folder / differences),
        "reference_file": str(folder / "reference.png"),
    }
