"""The core's settings that a caller may give by name: their types, and what they mean."""

from __future__ import annotations

from typing import TypedDict


class CoreOptions(TypedDict, total=False):
    """Fields of the C structure ``rvdnav_config``; the library's own value is taken for what isn't given."""

    isa: str | int
    edge_floor: int
    edge_weber_q8: int
    edge_knee: int
    edge_min_run: int
    hough_rho_bins: int
    hough_spread: int
    peak_min_votes: int
    segment_min_length: int
    segment_max_gap: int
    max_edgels: int
    max_peaks: int
    max_segments: int
    max_bars: int
    max_hypotheses: int
    match_half_window: int
    match_row_tolerance: int
    match_min_score_q8: int
    match_uniqueness_q8: int
    match_max_gradient_q8: int
    match_consistency_q8: int
    range_min: float
    range_max: float
    blur_sigma: float


# Unit and meaning.
MEANINGS: dict[str, tuple[str, str]] = {
    "isa": ("", "Instruction set of the row kernels"),
    "edge_floor": ("grey levels", "Least step of an edge pixel"),
    "edge_weber_q8": ("1/256", "Least step of an edge pixel as a part of the local mean"),
    "edge_knee": ("grey level", "Local mean above which that part is a fourth"),
    "edge_min_run": ("px", "Shortest connected edge that is kept"),
    "hough_rho_bins": ("px", "Bins of Hough space across; 0: as many as the rectified images need"),
    "hough_spread": ("deg", "Half-width of an edge pixel's votes around its gradient's direction"),
    "peak_min_votes": ("", "Votes from which a maximum of Hough space is a peak"),
    "segment_min_length": ("px", "Shortest segment of a line"),
    "segment_max_gap": ("px", "Longest gap that a segment bridges"),
    "max_edgels": ("", "Edge pixels of an image that are kept; 0: a sixteenth of its pixels, at least 65536"),
    "max_peaks": ("", "Peaks of Hough space that are kept"),
    "max_segments": ("", "Segments of an image that are kept"),
    "max_bars": ("", "Pairs of segments of an image that are kept"),
    "max_hypotheses": ("", "Brackets that are looked at in a search"),
    "match_half_window": ("px", "Half-width of the windows that are correlated"),
    "match_row_tolerance": ("px", "Rows that a point may lie off its epipolar line"),
    "match_min_score_q8": ("1/256", "Least correlation (ZNCC) of a match"),
    "match_uniqueness_q8": ("1/256", "Part of a match's correlation below which its best rival must stay"),
    "match_max_gradient_q8": ("1/256", "Largest gradient of the disparity between neighbours"),
    "match_consistency_q8": ("1/256 px", "Largest disagreement of the match from left to right with that back"),
    "range_min": ("m", "Nearest range at which a target is searched"),
    "range_max": ("m", "Farthest range at which a target is searched"),
    "blur_sigma": ("px", "Standard deviation of a sharp image's edges: lens and pixel together"),
}
