"""What earlier frames tell of the next one."""

from __future__ import annotations

import attrs

from rvdnav.pose import PredictedPose
from rvdnav.pose.arrays import IntArray


@attrs.frozen(eq=False)
class Expectation:
    """Where the target is expected, and how its edges look.

    prediction: of its pose.  polarity (cameras, edges): of its edges as last seen, see `Measurement.polarity`; 0 where
    unknown.  earlier_odds: logarithm of the odds for the prediction's side where earlier frames could not decide
    between two poses; None where they did.
    """

    prediction: PredictedPose
    polarity: IntArray
    earlier_odds: float | None
