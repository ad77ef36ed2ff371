"""ViSP's camera settings (.xml) as camchain.yaml.

python examples/real/xml_to_rig.py CAMERA.xml FOLDER [WIDTH HEIGHT]
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from rvdnav.camera import CameraModel
from rvdnav.rig import Rig
from rvdnav.rig.files import save_rig


def camera_from_xml(path: Path, width: int = 640, height: int = 480) -> CameraModel:
    """The camera of the file's first <camera> element; the size is given where the file has none.

    ViSP's distortion from ideal to real coordinates, kud, is k1 of ours.  Raises ValueError for a file without camera.
    """
    camera = ET.parse(path).getroot().find(".//camera")
    if camera is None:
        raise ValueError(f"{path}: holds no <camera>")

    def value(key: str, default: float | None = None) -> float:
        text = camera.findtext(key)
        if text is None and default is None:
            raise ValueError(f"{path}: <camera> has no <{key}>")
        return float(text) if text is not None else float(default or 0.0)

    size = int(value("width", width)), int(value("height", height))
    return CameraModel(*size, value("px"), value("py"), value("u0"), value("v0"), [value("kud", 0.0), 0.0, 0.0, 0.0])


if __name__ == "__main__":
    camera = camera_from_xml(Path(sys.argv[1]), *map(int, sys.argv[3:5]))
    save_rig(Rig((camera,), (np.eye(4),)), sys.argv[2])
