"""Every stage of the core by itself, for tests, teaching and tuning."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.core import layout
from rvdnav.core.arrays import Records, aligned_block, collect, image_argument, pointer, points, records
from rvdnav.core.context import Context
from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check

THETA_BINS = 180
"""Rows of the Hough accumulator: theta = -45 .. 134 degrees."""

_MOST_PROFILES = 80  # across an edge, of sample_edges

UInt8Array = NDArray[np.uint8]
UInt16Array = NDArray[np.uint16]
UInt32Array = NDArray[np.uint32]
FloatArray = NDArray[np.float64]
RecordArray = NDArray[np.void]


def unpack_edges(edge_bits: UInt32Array, width: int) -> NDArray[np.bool_]:
    """Packed edge bits (h, words) as a mask (h, width)."""
    octets = np.ascontiguousarray(edge_bits, "<u4").view(np.uint8)
    return np.unpackbits(octets, axis=1, bitorder="little")[:, :width].astype(np.bool_)


class Stages(Context):
    """The stages in the order of the data; camera 0 is the left, 1 the right one.

    All raise CoreError when the core refuses the call, ValueError for arrays of a wrong shape or type.
    """

    def smooth(self, camera: int, image: UInt8Array) -> UInt8Array:
        """Smoothed image (h, w) by the 3x3 binomial."""
        c_image, keep = image_argument(image)
        out = np.empty(keep.shape, np.uint8)
        check(lib.rvdnav_smooth(self.handle, camera, c_image, pointer(out, "uint8_t *")))
        return out

    def detect_edges(self, camera: int, smoothed: UInt8Array) -> tuple[UInt32Array, UInt8Array]:
        """Packed edge bits (h, words) and gradient directions (h, w), 256 to the turn, of the adaptive Sobel."""
        smoothed = self._plane(smoothed)
        bits = np.empty(self._bits_shape, np.uint32)
        direction = np.empty(smoothed.shape, np.uint8)
        args = pointer(smoothed, "uint8_t *"), pointer(bits, "uint32_t *"), pointer(direction, "uint8_t *")
        check(lib.rvdnav_detect_edges(self.handle, camera, *args))
        return bits, direction

    def filter_edges(self, camera: int, edge_bits: UInt32Array) -> UInt32Array:
        """The edge bits without specks and short runs."""
        bits: UInt32Array = self._bits(edge_bits).copy()
        check(lib.rvdnav_filter_edges(self.handle, camera, pointer(bits, "uint32_t *")))
        return bits

    def thin(self, camera: int, edge_bits: UInt32Array) -> UInt32Array:
        """The edge bits thinned to single-pixel edges."""
        bits: UInt32Array = self._bits(edge_bits).copy()
        check(lib.rvdnav_thin(self.handle, camera, pointer(bits, "uint32_t *")))
        return bits

    def rectify_edges(self, camera: int, edge_bits: UInt32Array, direction: UInt8Array) -> RecordArray:
        """EDGEL records: the edge pixels in rectified coordinates."""
        bits = self._bits(edge_bits)
        direction = self._plane(direction)
        args = camera, pointer(bits, "uint32_t *"), pointer(direction, "uint8_t *")
        return collect(
            lambda out, capacity, count: lib.rvdnav_rectify_edges(self.handle, *args, out, capacity, count),
            "rvdnav_edgel *",
            layout.EDGEL,
            self.config.max_edgels,
        )

    def hough_vote(self, edgels: Records) -> UInt16Array:
        """Accumulator (180, hough_rho_bins): rows theta = -45 .. 134 degrees, rho = 0 in the middle column."""
        edgels = records(edgels, layout.EDGEL)
        accumulator = np.empty((THETA_BINS, self.config.hough_rho_bins), np.uint16)
        args = pointer(edgels, "rvdnav_edgel *"), len(edgels), pointer(accumulator, "uint16_t *")
        check(lib.rvdnav_hough_vote(self.handle, *args))
        return accumulator

    def hough_peaks(self, accumulator: UInt16Array) -> RecordArray:
        """PEAK records: local maxima of the accumulator, most votes first."""
        shape = (THETA_BINS, self.config.hough_rho_bins)
        if accumulator.shape != shape:
            raise ValueError(f"expected an accumulator of shape {shape}, not {accumulator.shape}")
        cells = np.ascontiguousarray(accumulator, np.uint16)
        return collect(
            lambda out, capacity, count: lib.rvdnav_hough_peaks(
                self.handle, pointer(cells, "uint16_t *"), out, capacity, count
            ),
            "rvdnav_peak *",
            layout.PEAK,
            self.config.max_peaks,
        )

    def hough_track(self, camera: int, edgels: Records, windows: Records) -> RecordArray:
        """PEAK records, one for each window (WINDOW records); votes = 0 where a window holds no peak."""
        edgels = records(edgels, layout.EDGEL)
        c_windows = records(windows, layout.WINDOW)
        peaks = np.empty(len(c_windows), layout.PEAK)
        args = pointer(edgels, "rvdnav_edgel *"), len(edgels), pointer(c_windows, "rvdnav_window *"), len(c_windows)
        check(lib.rvdnav_hough_track(self.handle, camera, *args, pointer(peaks, "rvdnav_peak *")))
        return peaks

    def extract_segments(self, camera: int, edgels: Records, peaks: Records) -> RecordArray:
        """SEGMENT records: straight runs of edgels along the peaks' lines."""
        edgels = records(edgels, layout.EDGEL)
        peaks = records(peaks, layout.PEAK)
        args = pointer(edgels, "rvdnav_edgel *"), len(edgels), pointer(peaks, "rvdnav_peak *"), len(peaks)
        return collect(
            lambda out, capacity, count: lib.rvdnav_extract_segments(self.handle, camera, *args, out, capacity, count),
            "rvdnav_segment *",
            layout.SEGMENT,
            self.config.max_segments,
        )

    def find_bars(self, camera: int, segments: Records) -> RecordArray:
        """BAR records: pairs of near-parallel segments with a small distance."""
        segments = records(segments, layout.SEGMENT)
        args = pointer(segments, "rvdnav_segment *"), len(segments)
        return collect(
            lambda out, capacity, count: lib.rvdnav_find_bars(self.handle, camera, *args, out, capacity, count),
            "rvdnav_bar *",
            layout.BAR,
            self.config.max_bars,
        )

    def measure_edges(
        self,
        camera: int,
        image: UInt8Array,
        model_edges: ArrayLike,
        polarity: ArrayLike = 0,
        half_width: float = 4.0,
        step: float = 1.0,
        *,
        face: ArrayLike = 0.0,
        blur_sigma: ArrayLike = 0.0,
    ) -> RecordArray:
        """EDGE_SAMPLE records: steps of the raw grey values across model edges.

        model_edges: (n, 4) rectified x0, y0, x1, y1; polarity: +1, -1 or 0 (either) for all or each; half_width of the
        profiles and their distance step along the edges in pixels.  face: for all or each, the width in pixels of the
        even face that it bounds, positive towards the normal (-dy, dx), 0 unknown.  blur_sigma: for all or each, of the
        steps, pixels; 0 that of the configuration.
        """
        c_image, _keep = image_argument(image)
        ends = points(model_edges, 4)
        edges = np.zeros(len(ends), layout.MODEL_EDGE)
        for column, name in enumerate(("x0", "y0", "x1", "y1")):
            edges[name] = ends[:, column]
        edges["polarity"] = polarity
        edges["face"] = face
        edges["blur"] = blur_sigma
        lengths = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
        guess = int(np.sum(lengths / step + 2)) if step > 0 and np.all(np.isfinite(lengths)) else 1
        args = camera, c_image, pointer(edges, "rvdnav_model_edge *"), len(edges), half_width, step, 0.0
        return collect(
            lambda out, capacity, count: lib.rvdnav_measure_edges(self.handle, *args, out, capacity, count),
            "rvdnav_edge_sample *",
            layout.EDGE_SAMPLE,
            min(guess, 1 << 16),
        )

    def sample_edges(
        self, images: Sequence[UInt8Array | None], edges: Records, half_width: float, shortest: float = 0.0
    ) -> tuple[RecordArray, RecordArray]:
        """EDGE_SAMPLE records: steps across a target's edges (SEEN_EDGE records) where a pose puts them; and
        EDGE_COVERAGE records: what of each edge could be measured.

        images: of each camera, None where no edge is seen in it.  half_width: of the profiles, px; edges shorter than
        shortest, px, are left out.
        """
        edges = records(edges, layout.SEEN_EDGE)
        given = [(ffi.NULL, None) if image is None else image_argument(image) for image in images]
        left, right = ([c_image for c_image, _ in given] + [ffi.NULL])[:2]
        coverage = np.zeros(len(edges), layout.EDGE_COVERAGE)
        args = left, right, pointer(edges, "rvdnav_seen_edge *"), len(edges), half_width, shortest
        covered = pointer(coverage, "rvdnav_edge_coverage *")
        samples = collect(
            lambda out, capacity, count: lib.rvdnav_sample_edges(self.handle, *args, out, capacity, count, covered),
            "rvdnav_edge_sample *",
            layout.EDGE_SAMPLE,
            _MOST_PROFILES * len(edges),
        )
        return samples, coverage

    def correlate(self, left: UInt8Array, right: UInt8Array, xy: ArrayLike) -> RecordArray:
        """MATCH records of the left rectified points xy (n, 2), found along the rows of the right image."""
        c_left, _keep_left = image_argument(left)
        c_right, _keep_right = image_argument(right)
        xy = points(xy, 2)
        matches = np.zeros(len(xy), layout.MATCH)
        matches["x"], matches["y"] = xy[:, 0], xy[:, 1]
        matches["bar"] = -1
        check(lib.rvdnav_correlate(self.handle, c_left, c_right, pointer(matches, "rvdnav_match *"), len(matches)))
        return matches

    def triangulate(self, left: ArrayLike, right: ArrayLike) -> FloatArray:
        """World points (n, 3), metres, of rectified left and right points (n, 2)."""
        xy_left, xy_right = points(left, 2), points(right, 2)
        if len(xy_left) != len(xy_right):
            raise ValueError(f"{len(xy_left)} left points but {len(xy_right)} right ones")
        p_W = np.empty((len(xy_left), 3))
        args = pointer(xy_left, "double *"), pointer(xy_right, "double *"), len(p_W), pointer(p_W, "double *")
        check(lib.rvdnav_triangulate(self.handle, *args))
        return p_W

    def surface(self, left: UInt8Array, right: UInt8Array) -> tuple[RecordArray, int]:
        """SURFACE_POINT records: zero crossings matched along the epipolar rows of both images, in space; and how many
        zero crossings the left image has, matched or not.

        Raises CoreError for a rig of one camera.
        """
        c_left, _keep_left = image_argument(left)
        c_right, _keep_right = image_argument(right)
        size = ffi.new("size_t *")
        check(lib.rvdnav_surface_size(self.handle, size))
        block, _keep = aligned_block(size[0])
        crossings = ffi.new("uint32_t *")
        points = collect(
            lambda out, capacity, count: lib.rvdnav_surface(
                self.handle, c_left, c_right, block, size[0], out, capacity, count, crossings
            ),
            "rvdnav_surface_point *",
            layout.SURFACE_POINT,
            self.width * self.height // 8,
        )
        return points, int(crossings[0])

    @property
    def _bits_shape(self) -> tuple[int, int]:
        return self.height, int(lib.rvdnav_edge_row_words(self.width))

    def _bits(self, edge_bits: UInt32Array) -> UInt32Array:
        if edge_bits.shape != self._bits_shape or edge_bits.dtype != np.uint32:
            raise ValueError(f"expected edge bits uint32 {self._bits_shape}, not {edge_bits.dtype} {edge_bits.shape}")
        return np.ascontiguousarray(edge_bits)

    def _plane(self, plane: UInt8Array) -> UInt8Array:
        shape = (self.height, self.width)
        if plane.shape != shape or plane.dtype != np.uint8:
            raise ValueError(f"expected uint8 {shape}, not {plane.dtype} {plane.shape}")
        return np.ascontiguousarray(plane)
