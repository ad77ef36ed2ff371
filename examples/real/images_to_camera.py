"""A folder of numbered pictures, of any kind that OpenCV reads, as the images of a sequence's camera.

python examples/real/images_to_camera.py PICTURES SEQUENCE/cam0 [FRAMES_PER_SECOND]
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2

START_NS = 1_700_000_000_000_000_000


def write_camera(pictures: list[Path], camera: Path, rate: float = 25.0) -> list[int]:
    """Write the pictures as PNG files of grey values, the given number a second, and return their stamps, ns.

    Raises ValueError for a file that is no picture, and where there are none.
    """
    if not pictures:
        raise ValueError(f"{camera}: there are no pictures for it")
    (camera / "data").mkdir(parents=True, exist_ok=True)
    stamps = [START_NS + round(index * 1e9 / rate) for index in range(len(pictures))]
    for stamp, picture in zip(stamps, pictures, strict=True):
        pixels = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE)
        if pixels is None:
            raise ValueError(f"{picture}: no picture")
        cv2.imwrite(str(camera / "data" / f"{stamp}.png"), pixels)
    rows = [f"{stamp},{stamp}.png" for stamp in stamps]
    (camera / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows, ""]))
    return stamps


if __name__ == "__main__":
    files = sorted(file for file in Path(sys.argv[1]).iterdir() if file.is_file())
    write_camera(files, Path(sys.argv[2]), *map(float, sys.argv[3:4]))
