"""The library by plain ctypes: the C ABI needs nothing of the binding."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p

import numpy as np
import pytest
from rvdnav.core import LIBRARY_PATH

WIDTH, HEIGHT = 96, 64


class Image(ctypes.Structure):
    _fields_ = [("data", POINTER(c_uint8)), ("width", c_int32), ("height", c_int32), ("stride", c_int32)]


class Camera(ctypes.Structure):
    _fields_ = [*((name, c_double) for name in ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")), ("R", c_double * 9)]


class Rig(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_int32),
        ("height", c_int32),
        ("camera_count", c_int32),
        ("focal_rect", c_double),
        ("baseline", c_double),
        ("camera", Camera * 2),
    ]


class ConfigHead(ctypes.Structure):
    """What a caller must know of rvdnav_config to ask for its defaults."""

    _fields_ = [("struct_size", c_uint32), ("isa", c_int32)]


@pytest.fixture(scope="module")
def library():
    found = ctypes.CDLL(str(LIBRARY_PATH))
    found.rvdnav_status_text.restype = c_char_p
    found.rvdnav_struct_size.argtypes = [c_char_p]
    found.rvdnav_struct_size.restype = c_uint32
    found.rvdnav_context_size.argtypes = [c_void_p, c_void_p, POINTER(c_size_t)]
    found.rvdnav_context_init.argtypes = [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, POINTER(c_void_p)]
    found.rvdnav_smooth.argtypes = [c_void_p, c_int32, c_void_p, c_void_p]
    found.rvdnav_host_clock.argtypes = [c_void_p]
    found.rvdnav_host_clock.restype = c_uint64
    return found


def test_it_names_itself(library):
    assert library.rvdnav_abi_version() == 3
    assert library.rvdnav_status_text(0) == b"ok"
    assert b"null" in library.rvdnav_status_text(-1)
    assert library.rvdnav_struct_size(b"rvdnav_rig") == ctypes.sizeof(Rig)
    assert library.rvdnav_struct_size(b"rvdnav_image") == ctypes.sizeof(Image)
    first = library.rvdnav_host_clock(None)
    assert library.rvdnav_host_clock(None) >= first > 0


def test_it_smooths_an_image(library):
    rig = Rig(struct_size=ctypes.sizeof(Rig), width=WIDTH, height=HEIGHT, camera_count=1, focal_rect=90.0)
    camera = rig.camera[0]
    camera.fx = camera.fy = 90.0
    camera.cx, camera.cy = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
    camera.R[0] = camera.R[4] = camera.R[8] = 1.0
    config = ctypes.create_string_buffer(library.rvdnav_struct_size(b"rvdnav_config"))
    ConfigHead.from_buffer(config).struct_size = len(config)
    assert library.rvdnav_config_default(config) == 0

    size = c_size_t()
    assert library.rvdnav_context_size(config, byref(rig), byref(size)) == 0
    memory = ctypes.create_string_buffer(size.value + 64)
    aligned = (ctypes.addressof(memory) + 63) // 64 * 64
    context = c_void_p()
    assert library.rvdnav_context_init(aligned, size, config, byref(rig), None, byref(context)) == 0

    pixels = np.zeros((HEIGHT, WIDTH), np.uint8)
    pixels[30, 40] = 160
    image = Image(pixels.ctypes.data_as(POINTER(c_uint8)), WIDTH, HEIGHT, WIDTH)
    smoothed = np.empty_like(pixels)
    assert library.rvdnav_smooth(context, 0, byref(image), smoothed.ctypes.data) == 0
    assert np.array_equal(smoothed[29:32, 39:42], [[10, 20, 10], [20, 40, 20], [10, 20, 10]])
    assert smoothed.sum() == 160

    image.width += 1
    assert library.rvdnav_smooth(context, 0, byref(image), smoothed.ctypes.data) == -6
