"""A sequence played back with faults."""

from __future__ import annotations

import zlib
from collections.abc import Iterable

import numpy as np

from rvdnav.errors import InputError
from rvdnav.faults.catalog import CALIBRATION_FAULTS, DELIVERY_FAULTS, PIXEL_FAULTS, STEREO_FAULTS
from rvdnav.faults.delivery import LEFT, RIGHT, Source, as_recorded
from rvdnav.faults.fault import Fault
from rvdnav.faults.region import target_region
from rvdnav.faults.response import Response
from rvdnav.images import Image
from rvdnav.sequence import Frame, Sequence
from rvdnav.solution import Solution


class FaultySequence(Sequence):
    """A sequence as it would have arrived with the faults, in the order of arrival.

    The faults of the delivery come first, then those of the images, each kind in the order given; ``rig`` is what a
    navigator is told, wrong where the calibration is at fault.  The truth stays that of the stamps.  Every frame is a
    function of the recorded frames, its number and the seed.

    Raises InputError for a fault that strikes beyond the last frame, or a camera that isn't there.
    """

    def __init__(self, recorded: Sequence, faults: Iterable[Fault], seed: int = 0) -> None:
        self._recorded = recorded
        self._faults = tuple(faults)
        self._seed = seed
        rig, deliveries = recorded.rig, as_recorded(len(recorded))
        for fault in self._faults:
            last = max((frames[-1] for frames in fault.frames or ()), default=-1)
            if last >= len(recorded):
                raise InputError(f"{recorded.path}: fault {fault.name}: there is no frame {last}")
            if fault.name in STEREO_FAULTS and not rig.is_stereo:
                raise InputError(f"{recorded.path}: fault {fault.name}: there is one camera")
            if fault.name in CALIBRATION_FAULTS:
                rig = CALIBRATION_FAULTS[fault.name](rig)
            if fault.name in DELIVERY_FAULTS:
                deliveries = DELIVERY_FAULTS[fault.name](deliveries, fault.strikes)
        self._deliveries = deliveries
        super().__init__(recorded.path, rig, recorded.target, recorded.truth, [], [])

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
        stamped = self._recorded[delivery.index]
        left, right = (
            self._image(stamped, delivery.index, camera, source)
            for camera, source in ((LEFT, delivery.left), (RIGHT, delivery.right))
        )
        return Frame(stamped.timestamp_ns, left, right)

    def _image(self, stamped: Frame, index: int, camera: int, source: Source) -> Image | None:
        """What arrives as a camera's image in the frame of that number."""
        shown = stamped if source.frame == index else self._recorded[source.frame]
        image = shown.right if source.camera == RIGHT else shown.left
        if image is None:
            return None
        own = stamped.right if camera == RIGHT else stamped.left
        pixels = image.pixels
        for fault in self._faults:
            effect = PIXEL_FAULTS.get(fault.name)
            if effect is None or camera not in effect.cameras or not fault.strikes(index):
                continue
            region = target_region(self._recorded.rig, self.target, self.truth, stamped.timestamp_ns, camera)
            rng = np.random.default_rng([self._seed, zlib.crc32(fault.name.encode()), index, camera])
            pixels = effect.effect(pixels, region, rng)
        return Image(pixels, stamped.timestamp_ns if own is None else own.timestamp_ns)
