"""Image files of every kind: pixels as stored, whatever they say about turning them, and none that harm."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import png
from rvdnav.calibration import read_pairs
from rvdnav.images import ImageError, Raster, image_size, read_image

GREY = np.random.default_rng(7).integers(0, 256, (30, 41)).astype(np.uint8)
SMOOTH = cv2.GaussianBlur(GREY, (0, 0), 3.0)  # what JPEG keeps well
DEEP = np.random.default_rng(8).integers(0, 65536, (30, 41)).astype(np.uint16)
UPRIGHT = 1


def encoded(ending: str, pixels: np.ndarray) -> bytes:
    done, data = cv2.imencode(ending, pixels)
    assert done
    return data.tobytes()


def exif(orientation: int, order: str) -> bytes:
    """A TIFF header with the orientation as its only tag."""
    mark = b"II*\0" if order == "<" else b"MM\0*"
    return mark + struct.pack(f"{order}IHHHIHHI", 8, 1, 274, 3, 1, orientation, 0, 0)


def jpeg(orientation: int, order: str = "<") -> bytes:
    data = encoded(".jpg", SMOOTH)
    contents = b"Exif\0\0" + exif(orientation, order)
    return data[:2] + b"\xff\xe1" + struct.pack(">H", 2 + len(contents)) + contents + data[2:]


def chunk(name: bytes, contents: bytes) -> bytes:
    return struct.pack(">I", len(contents)) + name + contents + struct.pack(">I", zlib.crc32(name + contents))


def png_with(name: bytes, contents: bytes) -> bytes:
    data = png(GREY)
    return data[:33] + chunk(name, contents) + data[33:]


def tiff(pixels: np.ndarray = GREY, orientation: int = UPRIGHT, order: str = "<", **changes: int) -> bytes:
    """One strip without compression; changes: of a tag's value, by its number with t before it."""
    height, width = pixels.shape
    bits = 8 * pixels.itemsize
    stored = pixels.astype(pixels.dtype.newbyteorder(order)).tobytes()
    tags = {256: width, 257: height, 258: bits, 259: 1, 262: 1, 273: 8, 274: orientation, 277: 1, 278: height}
    tags[279] = len(stored)
    tags |= {int(name[1:]): value for name, value in changes.items()}
    entries = b"".join(struct.pack(f"{order}HHII", tag, 4, 1, value) for tag, value in sorted(tags.items()))
    mark = b"II*\0" if order == "<" else b"MM\0*"
    directory = struct.pack(f"{order}H", len(tags)) + entries + bytes(4)
    return mark + struct.pack(f"{order}I", 8 + len(stored)) + stored + directory


def written(folder: Path, data: bytes, name: str = "image") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("order", ["<", ">"])
def test_pixels_stay_as_stored_whatever_exif_says(tmp_path: Path, orientation: int, order: str) -> None:
    plain = cv2.imdecode(np.frombuffer(encoded(".jpg", SMOOTH), np.uint8), cv2.IMREAD_GRAYSCALE)
    for data, pixels in (
        (png_with(b"eXIf", exif(orientation, order)), GREY),
        (jpeg(orientation, order), plain),
        (tiff(GREY, orientation, order), GREY),
        (tiff(DEEP, orientation, order), DEEP),
    ):
        path = written(tmp_path, data)
        assert image_size(path) == (41, 30)
        raster = read_image(path)
        np.testing.assert_array_equal(raster.pixels, pixels)
        assert raster.orientation == orientation
        assert (raster.ignored_orientation is None) == (orientation == UPRIGHT)


def test_calibration_pictures_stay_as_stored_and_it_is_said_once(tmp_path: Path) -> None:
    for name, data in (("left1", jpeg(6)), ("right1", jpeg(1)), ("left2", jpeg(6)), ("right2", jpeg(6))):
        written(tmp_path, data, f"{name}.jpg")
    notices: list[str] = []
    # Both images of a pair are there, which its type leaves open.
    shapes = [image.shape for pair in read_pairs(tmp_path, notices) for image in pair.images]  # type: ignore[union-attr]
    assert shapes == [(30, 41)] * 4
    assert notices == ["EXIF orientation 6 is ignored, the pixels are taken as stored, left1.jpg the first of them"]


@pytest.mark.parametrize("ending", [".png", ".tif", ".pgm", ".bmp"])
def test_every_lossless_kind_gives_its_levels(tmp_path: Path, ending: str) -> None:
    path = written(tmp_path, encoded(ending, GREY))
    np.testing.assert_array_equal(read_image(path).grey8, GREY)
    if ending == ".bmp":
        return
    deep = read_image(written(tmp_path, encoded(ending, DEEP)))
    np.testing.assert_array_equal(deep.pixels, DEEP)
    np.testing.assert_array_equal(deep.grey8, np.rint(DEEP / 257.0))
    assert deep.conversion == "16-bit images are converted to 8-bit grey"


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_images_of_few_bits_keep_their_levels(bits: int) -> None:
    """In the low bits of 16, also where the scene is dark, and whatever a few hot pixels show."""
    scene = np.tile(np.linspace(0.0, 1.0, 1000), (20, 1))
    for exposure in (1.0, 0.3):
        levels = np.rint(exposure * scene * (2**bits - 1)).astype(np.uint16)
        levels[0, ::100] = 2**bits - 1
        grey = Raster(levels).grey8
        assert len(np.unique(grey[1])) >= min(190, int(exposure * 2**bits) // 5)
        assert (np.diff(grey[1].astype(int)) >= 0).all()
        assert np.mean(grey[1] == 255) < 0.005


@pytest.mark.parametrize(("largest", "white"), [(100, 255), (1023, 65535), (4095, 65535)])
@pytest.mark.parametrize("plain", [False, True])
def test_white_is_what_a_pgm_says(tmp_path: Path, largest: int, white: int, plain: bool) -> None:
    levels = np.arange(12) * largest // 11
    words = b" ".join(b"%d" % level for level in levels)
    raw = levels.astype(">u2" if largest > 255 else np.uint8).tobytes()
    data = b"P%d # of a camera\n4 3\n%d\n" % (2 if plain else 5, largest)
    pixels = read_image(written(tmp_path, data + (words if plain else raw))).pixels
    np.testing.assert_array_equal(pixels.ravel(), np.floor(levels * white / largest + 0.5))


def test_the_decoder_sees_no_chunks_but_those_of_the_pixels(tmp_path: Path) -> None:
    path = written(tmp_path, png_with(b"acTL", struct.pack(">II", 2**31, 0)))
    np.testing.assert_array_equal(read_image(path).pixels, GREY)


def sized_jpeg(width: int, height: int) -> bytes:
    data = encoded(".jpg", SMOOTH)
    at = data.index(b"\xff\xc0") + 5
    return data[:at] + struct.pack(">HH", height, width) + data[at + 4 :]


def sized_bmp(width: int, height: int) -> bytes:
    data = encoded(".bmp", GREY)
    return data[:18] + struct.pack("<ii", width, height) + data[26:]


def sized_png(width: int, height: int) -> bytes:
    return png(GREY)[:8] + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + png(GREY)[33:]


HUGE = {
    "png": sized_png(2**31 - 1, 2**31 - 1),
    "png long": sized_png(2**20, 1),
    "png many": sized_png(16384, 16384),
    "jpeg": sized_jpeg(65535, 65535),
    "tiff": tiff(t256=2**32 - 1, t257=2**32 - 1),
    "tiff tile": tiff(t322=2**32 - 16, t323=16, t324=8, t325=8),
    "bmp": sized_bmp(2**31 - 1, -(2**31)),
    "pgm": b"P5 99999 99999 255\n",
    "pgm plain": b"P2 9000 9000 255\n0 0",
}


@pytest.mark.parametrize("kind", HUGE)
def test_a_huge_image_is_refused_by_its_header(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path, HUGE[kind])
    for read in (image_size, read_image):
        with pytest.raises(ImageError, match="which is none of a camera"):
            read(path)


WHOLE = {
    "png": png(GREY),
    "jpeg": encoded(".jpg", SMOOTH),
    "tiff": tiff(),
    "pgm": encoded(".pgm", GREY),
    "plain pgm": b"P2 4 3 9\n" + b"1 " * 12,
    "bmp": encoded(".bmp", GREY),
}


@pytest.mark.parametrize("kind", WHOLE)
def test_a_truncated_image_is_refused(tmp_path: Path, kind: str) -> None:
    data = WHOLE[kind]
    read_image(written(tmp_path, data))
    for length in {0, 1, 2, 9, len(data) // 4, len(data) // 2, len(data) - len(data) // 8}:
        with pytest.raises(ImageError):
            read_image(written(tmp_path, data[:length]))


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"GIF89a" + bytes(40), "is not a PNG, JPEG, TIFF, BMP or PGM image"),
        (tiff(t339=3), "no whole numbers of 8 or 16 bits"),
        (tiff(t258=32), "no whole numbers of 8 or 16 bits"),
        (b"P5 4 3 65536\n" + bytes(24), "is corrupt"),
        (b"P2 4 1 9\n1 2 x 4", "is corrupt"),
        (encoded(".jpg", SMOOTH)[:-2] + b"\xff\xda\0\x02" * 31 + b"\xff\xd9", "more than 30 scans"),
    ],
)
def test_what_is_no_image_of_ours(tmp_path: Path, data: bytes, fault: str) -> None:
    with pytest.raises(ImageError, match=fault):
        read_image(written(tmp_path, data))


def test_what_is_no_plain_file(tmp_path: Path) -> None:
    for path, fault in (
        (Path("/dev/zero"), "not a plain file"),
        (tmp_path / "nul\0", "No such file"),
        (tmp_path / ("x" * 300), "File name too long"),
        (tmp_path, "directory"),
    ):
        with pytest.raises(ImageError, match=fault):
            read_image(path)
