"""The navigator: from stereo frames to poses with covariance and an honest health state."""

from rvdnav.navigator.initial_pose import parse_pose
from rvdnav.navigator.navigator import Navigator
from rvdnav.navigator.settings import NavigatorSettings

__all__ = ["Navigator", "NavigatorSettings", "parse_pose"]
