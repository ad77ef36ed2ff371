"""A sequence played back with faults."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from functools import lru_cache, partial

import numpy as np

from rvdnav.errors import InputError
from rvdnav.faults.catalog import (
    DELIVERY_FAULTS,
    MISCALIBRATIONS,
    PIXEL_FAULTS,
    RIG_FAULTS,
    STEREO_FAULTS,
    TARGET_FAULTS,
)
from rvdnav.faults.delivery import LEFT, RIGHT, Source, as_recorded
from rvdnav.faults.fault import Fault
from rvdnav.faults.response import Response
from rvdnav.faults.view import View
from rvdnav.images import Image, PixelArray
from rvdnav.sequence import PAIRING_TOLERANCE_NS, Frame, Sequence
from rvdnav.solution import Solution


class FaultySequence(Sequence):
    """A sequence as it would have arrived with the faults, in the order of arrival.

    The faults of the delivery come first, then those of the images, each kind in the order given; ``rig`` and
    ``target`` are what a navigator is told, wrong where that is at fault.  The truth stays that of the stamps.  Every
    frame is a function of the recorded frames, its number and the seed.

    Raises InputError for a fault that strikes beyond the last frame, or a camera that isn't there, and for errors that
    leave no target or rig; a frame of it, for a fault that needs the true motion where there is none.
    """

    def __init__(self, recorded: Sequence, faults: Iterable[Fault], seed: int = 0) -> None:
        self._recorded = recorded
        # Each is asked for once a camera and, where a field of it is shown, with the frame before.
        self._frame = lru_cache(maxsize=2)(recorded.__getitem__)
        self._faults = tuple(faults)
        self._seed = seed
        rig, target, deliveries = recorded.rig, recorded.target, as_recorded(len(recorded))
        for fault in self._faults:
            self._check(fault)
            if fault.name in MISCALIBRATIONS:
                rig = MISCALIBRATIONS[fault.name](rig)
            try:
                if fault.name in RIG_FAULTS:
                    rig = RIG_FAULTS[fault.name](rig, self._rng(fault), *fault.strength)
                if fault.name in TARGET_FAULTS:
                    target = TARGET_FAULTS[fault.name](target, self._rng(fault), *fault.strength)
            except ValueError as error:
                raise InputError(f"{recorded.path}: fault {fault.label}: {error}") from error
            if fault.name in DELIVERY_FAULTS:
                deliveries = DELIVERY_FAULTS[fault.name](deliveries, fault.strikes)
        self._deliveries = deliveries
        super().__init__(recorded.path, rig, target, recorded.truth, [], [])

    def _check(self, fault: Fault) -> None:
        recorded = self._recorded
        told = f"{recorded.path}: fault {fault.name}"
        last = max((frames[-1] for frames in fault.frames or ()), default=-1)
        if last >= len(recorded):
            raise InputError(f"{told}: there is no frame {last}")
        if fault.name in STEREO_FAULTS and not recorded.rig.is_stereo:
            raise InputError(f"{told}: there is one camera")
        if fault.name in TARGET_FAULTS and not recorded.target.dimensions_known:
            raise InputError(f"{told}: the target's dimensions are unknown anyway")

    def _rng(self, fault: Fault, *numbers: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, zlib.crc32(fault.name.encode()), *numbers])

    @property
    def notices(self) -> list[str]:
        """Those of the recorded sequence."""
        return self._recorded.notices

    @property
    def timestamps_ns(self) -> tuple[int, ...]:
        """Of every frame, in the order of arrival."""
        recorded = self._recorded.timestamps_ns
        return tuple(recorded[delivery.index] for delivery in self._deliveries)

    def response(self, fault: Fault, solutions: Iterable[Solution]) -> Response:
        """What became of one of the faults in a run over this sequence; solutions in the order of arrival."""
        recorded = self._recorded.timestamps_ns
        return Response.of([ns for index, ns in enumerate(recorded) if fault.strikes(index)], solutions)

    def __len__(self) -> int:
        return len(self._deliveries)

    def __getitem__(self, index: int) -> Frame:
        """The frame at a position in the order of arrival.  Raises IndexError beyond the end."""
        delivery = self._deliveries[index]
        stamped = self._frame(delivery.index)
        left, right = (
            self._image(stamped, delivery.index, camera, source)
            for camera, source in ((LEFT, delivery.left), (RIGHT, delivery.right))
        )
        return Frame(stamped.timestamp_ns, left, right)

    def _image(self, stamped: Frame, index: int, camera: int, source: Source) -> Image | None:
        """What arrives as a camera's image in the frame of that number."""
        pixels = self._pixels(index, camera, source, self._faults)
        if pixels is None:
            return None
        own = stamped.right if camera == RIGHT else stamped.left
        return Image(pixels, stamped.timestamp_ns if own is None else own.timestamp_ns)

    def _pixels(self, index: int, camera: int, source: Source, faults: tuple[Fault, ...]) -> PixelArray | None:
        """Those of a source, with the faults that strike the frame of that number."""
        shown = self._frame(source.frame)
        image = shown.right if source.camera == RIGHT else shown.left
        if image is None:
            return None
        pixels = image.pixels
        for number, fault in enumerate(faults):
            effect = PIXEL_FAULTS.get(fault.name)
            if effect is None or camera not in effect.cameras or not fault.strikes(index):
                continue
            view = View(
                rig=self._recorded.rig,
                target=self._recorded.target,
                truth=self.truth,
                timestamp_ns=shown.timestamp_ns,
                camera=camera,
                recorded_at=partial(self._recorded_at, camera, source.camera, faults[:number]),
                sensor=self._rng(fault, camera),
            )
            pixels = effect.effect(pixels, view, self._rng(fault, index, camera), *fault.strength)
        return pixels

    def _recorded_at(
        self, camera: int, source_camera: int, faults: tuple[Fault, ...], timestamp_ns: int
    ) -> PixelArray | None:
        """The pixels of the frame recorded at a time, to within the tolerance of pairs, with those faults."""
        distances = [abs(ns - timestamp_ns) for ns in self._recorded.timestamps_ns]
        nearest = min(range(len(distances)), key=distances.__getitem__)
        if distances[nearest] > PAIRING_TOLERANCE_NS:
            return None
        return self._pixels(nearest, camera, Source(nearest, source_camera), faults)
