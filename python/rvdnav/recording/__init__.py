"""What a recording holds: the images that each camera lists, whatever their files, and which belong together."""

from rvdnav.recording.camera_folder import list_images
from rvdnav.recording.entry import Entry, check_images, missing
from rvdnav.recording.layouts import is_recording, read_recording
from rvdnav.recording.pairing import Moment, pair, single
from rvdnav.recording.recording import Recording

__all__ = [
    "Entry",
    "Moment",
    "Recording",
    "check_images",
    "is_recording",
    "list_images",
    "missing",
    "pair",
    "read_recording",
    "single",
]
