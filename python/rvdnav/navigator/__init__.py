"""The navigator: from stereo frames to poses with covariance and an honest health state."""

from rvdnav.navigator.navigator import Navigator
from rvdnav.navigator.settings import NavigatorSettings

__all__ = ["Navigator", "NavigatorSettings"]
