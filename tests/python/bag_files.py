"""ROS 2 bags as a recorder writes them, made by the library `rosbags` alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rvdnav.pose import inverse_T, quaternion_xyzw
from rvdnav.rig import Rig

TYPES = get_typestore(Stores.ROS2_HUMBLE)
STORAGES = {"sqlite3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}


def make(kind: str, *values: Any) -> Any:
    """A message of a type, such as "sensor_msgs/msg/Image", of its fields' values."""
    return TYPES.types[kind](*values)


def header(stamp_ns: int, frame: str) -> Any:
    seconds, rest = divmod(stamp_ns, 10**9)
    return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", seconds, rest), frame)


def image(
    stamp_ns: int,
    pixels: np.ndarray,
    encoding: str = "mono8",
    *,
    frame: str = "left",
    padding: int = 0,
    big: bool = False,
) -> Any:
    """pixels: (height, width) or (height, width, channels), as they are stored."""
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, -1)
    rows = np.hstack([rows, np.full((height, padding), 77, np.uint8)])
    return make(
        "sensor_msgs/msg/Image", header(stamp_ns, frame), height, width, encoding, int(big), rows.shape[1], rows.ravel()
    )


def compressed(stamp_ns: int, data: bytes, kind: str, frame: str = "left") -> Any:
    return make("sensor_msgs/msg/CompressedImage", header(stamp_ns, frame), kind, np.frombuffer(data, np.uint8))


def rectifying(rig: Rig) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """R (3, 3) and P (3, 4) of both cameras: x of the frame that they share from the left to the right centre."""
    f, cx, cy = 650.0, 340.0, 280.0
    R, P = [], []
    for camera in range(2):
        R_cam_world = rig.T_world_cam[camera][:3, :3].T
        x, forward = -R_cam_world[:, 2], R_cam_world[:, 0]  # z_W runs from the right to the left centre
        R.append(np.stack([x, np.cross(forward, x), forward]))
        shift = -f * rig.baseline * camera
        P.append(np.array([[f, 0.0, cx, shift], [0.0, f, cy, 0.0], [0.0, 0.0, 1.0, 0.0]]))
    return R, P


def camera_info(rig: Rig, camera: int, stamp_ns: int, frame: str, **changes: Any) -> Any:
    """Calibration of a stereo rig's camera as image_proc takes it; changes: of its fields, by their names."""
    model = rig.cameras[camera]
    R, P = rectifying(rig)
    region = make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    fields = {
        "header": header(stamp_ns, frame),
        "height": model.height,
        "width": model.width,
        "distortion_model": "plumb_bob",
        "d": np.array([*model.distortion, 0.0]),
        "k": model.K.ravel(),
        "r": R[camera].ravel(),
        "p": P[camera].ravel(),
        "binning_x": 0,
        "binning_y": 0,
        "roi": region,
        **changes,
    }
    return make("sensor_msgs/msg/CameraInfo", *fields.values())


def static_transforms(poses: dict[tuple[str, str], np.ndarray]) -> Any:
    """/tf_static: by the names of a frame and of one that hangs on it, T_frame_child (4, 4)."""
    stamped = []
    for (frame, child), T in poses.items():
        shift = make("geometry_msgs/msg/Vector3", *T[:3, 3])
        turn = make("geometry_msgs/msg/Quaternion", *quaternion_xyzw(T[:3, :3]))
        transform = make("geometry_msgs/msg/Transform", shift, turn)
        stamped.append(make("geometry_msgs/msg/TransformStamped", header(0, frame), child, transform))
    return make("tf2_msgs/msg/TFMessage", stamped)


def mounted(rig: Rig) -> Any:
    """/tf_static of a rig on a body: the left camera by way of a bracket, the right one at once."""
    T_body_world = np.array([[0.0, 0, 1, 0.3], [1, 0, 0, -0.1], [0, 1, 0, 0.2], [0, 0, 0, 1]])
    T_body_bracket = np.array([[0.0, -1, 0, 0.2], [1, 0, 0, 0.1], [0, 0, 1, -0.4], [0, 0, 0, 1]])
    T_body_left, T_body_right = (T_body_world @ T for T in rig.T_world_cam)
    return static_transforms(
        {
            ("bracket", "left"): inverse_T(T_body_bracket) @ T_body_left,
            ("body", "bracket"): T_body_bracket,
            ("body", "right"): T_body_right,
        }
    )


def write_bag(
    path: Path,
    messages: list[tuple[str, int, Any]],
    storage: str = "mcap",
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """A bag of (topic, time of logging, ns, message)."""
    bag = Writer(path, version=9, storage_plugin=STORAGES[storage])
    bag.set_compression(compression, CompressionFormat.ZSTD)
    with bag as writer:
        topics: dict[str, Any] = {}
        for topic, logged, message in messages:
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(topics[topic], logged, TYPES.serialize_cdr(message, kind))
    return path
