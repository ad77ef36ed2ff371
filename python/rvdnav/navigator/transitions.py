"""The navigator's states and when they change: one table."""

from __future__ import annotations

from rvdnav.solution import State

# state before the frame -> (after a good measurement, after none while coasting is allowed, after none for too long)
TRANSITIONS: dict[State, tuple[State, State, State]] = {
    State.SEARCHING: (State.TRACKING, State.SEARCHING, State.SEARCHING),
    State.TRACKING: (State.TRACKING, State.COASTING, State.LOST),
    State.COASTING: (State.TRACKING, State.COASTING, State.LOST),
    State.LOST: (State.TRACKING, State.SEARCHING, State.SEARCHING),
}


def next_state(state: State, *, measured: bool, coast_expired: bool) -> State:
    """The state after a frame: measured tells that a measurement passed every gate, coast_expired that the last such
    one is too long ago to predict from."""
    after_measurement, after_none, after_expiry = TRANSITIONS[state]
    if measured:
        return after_measurement
    return after_expiry if coast_expired else after_none
