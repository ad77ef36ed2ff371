"""The visible surface of the target as a point cloud, from one stereo frame."""

from rvdnav.reconstruction.cloud import UNMATCHED, Cloud, reconstruct
from rvdnav.reconstruction.ply import ply_bytes

__all__ = ["UNMATCHED", "Cloud", "ply_bytes", "reconstruct"]
