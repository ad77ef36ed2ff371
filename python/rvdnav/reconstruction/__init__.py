"""The visible surface of the target as a point cloud, from one stereo frame."""

from rvdnav.reconstruction.cloud import Cloud, reconstruct
from rvdnav.reconstruction.ply import ply_bytes

__all__ = ["Cloud", "ply_bytes", "reconstruct"]
