"""`calibration.html`: what was found, from what, what it is worth, and which picture would help most."""

from __future__ import annotations

from html import escape
from pathlib import Path

import attrs
import numpy as np

from rvdnav.calibration.calibrate import Calibration
from rvdnav.calibration.figures import coverage_figure, residual_figure, rig_figure, tilt_figure, view_figure
from rvdnav.calibration.next_view import NextView, next_views
from rvdnav.calibration.verdict import PoseSensitivity, pose_sensitivities
from rvdnav.evaluation import PAPER_ATTITUDE_RAD, PAPER_POSITION_M
from rvdnav.report.html import figure_html, note_html, section, table_html
from rvdnav.report.page import write_page
from rvdnav.rig.covariance import CAMERA_PARAMETERS

_SUGGESTIONS = 3


@attrs.frozen(eq=False)
class Verdict:
    """What the calibration is worth: how the pose answers to it, and the next pictures that would help most."""

    sensitivities: tuple[PoseSensitivity, ...]
    suggested: tuple[NextView, ...]


def verdict(calibration: Calibration) -> Verdict:
    """Judge a calibration by what it does to the mission's poses."""
    sensitivities = pose_sensitivities(calibration.rig)
    return Verdict(sensitivities, next_views(calibration.adjustment, calibration.board, sensitivities, _SUGGESTIONS))


def verdict_sentence(calibration: Calibration, judged: Verdict) -> str:
    """The verdict in one sentence."""
    if not judged.sensitivities:
        return "The bracket is nowhere in view of both cameras, so nothing can be said of its pose."
    farthest = judged.sensitivities[-1]
    position, attitude = farthest.sigmas(calibration.adjustment.covariance)
    good = 3.0 * position < PAPER_POSITION_M and 3.0 * attitude < PAPER_ATTITUDE_RAD
    return (
        f"At {farthest.range_m:g} m this calibration alone makes the pose err by {position * 1e3:.2f} mm and "
        f"{np.degrees(attitude):.3f}° (1σ): {'' if good else 'not '}good enough for 20 mm and 2° at 3σ."
    )


def write_calibration(path: Path, name: str, calibration: Calibration, judged: Verdict) -> None:
    """Write the report of a calibration from the pictures called ``name``."""
    sections = [
        section("Verdict", _verdict_html(calibration, judged)),
        section("Parameters", _parameters_html(calibration)),
        section("Residuals over the field", figure_html(residual_figure(calibration), "residuals")),
        section("Error of each view", figure_html(view_figure(calibration), "views") + _dropped_html(calibration)),
        section("Coverage of the field", figure_html(coverage_figure(calibration, judged.suggested), "coverage")),
        section("Coverage of tilt", figure_html(tilt_figure(calibration, judged.suggested), "tilt")),
        section("Rig and boards", figure_html(rig_figure(calibration, judged.suggested), "rig")),
    ]
    rig = calibration.rig
    subtitle = f"{calibration.board}, squares of {calibration.board.square * 1e3:g} mm; {rig.width}×{rig.height} px"
    write_page(path, name, subtitle, _tiles(calibration, judged), sections)


def _tiles(calibration: Calibration, judged: Verdict) -> list[tuple[str, str, str]]:
    adjustment = calibration.adjustment
    corners = int(np.isfinite(adjustment.residuals[..., 0]).sum())
    tiles = [
        ("views used", str(len(calibration.views)), f"{len(calibration.dropped)} dropped; {corners} corners"),
        ("RMS", f"{adjustment.rms_px:.3f} px", f"worst view {adjustment.view_rms_px.max():.3f} px"),
        ("baseline", f"{calibration.rig.baseline * 1e3:.2f} mm", "as true as the squares' size"),
    ]
    for sensitivity in judged.sensitivities:
        if sensitivity.range_m == 1.0:
            position, attitude = sensitivity.sigmas(adjustment.covariance)
            note = f"attitude σ {np.degrees(attitude):.3f}°; by the calibration alone"
            tiles.append(("position σ at 1 m", f"{position * 1e3:.2f} mm", note))
    return tiles


def _verdict_html(calibration: Calibration, judged: Verdict) -> str:
    text = f"<p>{escape(verdict_sentence(calibration, judged))}</p>"
    if not judged.sensitivities:
        return text
    head = ["range, m", "position σ, mm", "of it along the range, mm", "attitude σ, °"]
    head += [f"with picture {number}, mm / °" for number in range(1, len(judged.suggested) + 1)]
    rows = []
    for sensitivity in judged.sensitivities:
        position, attitude = sensitivity.sigmas(calibration.adjustment.covariance)
        along = sensitivity.range_sigma(calibration.adjustment.covariance)
        cells = [
            f"{sensitivity.range_m:g}",
            f"{position * 1e3:.3f}",
            f"{along * 1e3:.3f}",
            f"{np.degrees(attitude):.4f}",
        ]
        for view in judged.suggested:
            p, a = sensitivity.sigmas(view.covariance)
            cells.append(f"{p * 1e3:.3f} / {np.degrees(a):.4f}")
        rows.append(cells)
    text += table_html(head, rows)
    if judged.suggested:
        items = "".join(f"<li>{escape(view.description)}</li>" for view in judged.suggested)
        text += (
            "<p>The next pictures of the board would help most if taken like this, each in addition to those before it "
            "(dashed in the figures below):</p><ol>" + items + "</ol>"
        )
    return text + note_html(
        "For the paper's bracket (180 mm base, 140 mm high) squarely before the rig; σ of the "
        "length of the position's error and of the attitude's angle. The squares' size is taken as exact: an error of "
        "it scales every distance and shows in no picture."
    )


def _parameters_html(calibration: Calibration) -> str:
    sigmas = np.sqrt(np.diag(calibration.adjustment.covariance))
    rows = []
    values = [(c.fx, c.fy, c.cx, c.cy, *c.distortion) for c in calibration.rig.cameras]
    for index, name in enumerate(CAMERA_PARAMETERS):
        digits = 3 if index < 4 else 6
        unit = ", px" if index < 4 else ""
        cells = [f"{values[i][index]:.{digits}f} ± {sigmas[8 * i + index]:.{digits}f}" for i in range(2)]
        rows.append([name + unit, *cells])
    model = calibration.adjustment.model
    turn, shift = np.degrees(sigmas[16:19]), sigmas[19:] * 1e3
    text = table_html(["", "left", "right"], rows)
    position = ", ".join(f"{v * 1e3:.3f} ± {s:.3f}" for v, s in zip(model.T_cam1_cam0[:3, 3], shift, strict=True))
    rotation = ", ".join(f"{s:.4f}" for s in turn)
    text += f"<p>Left camera in the right one's frame: {position} mm; its rotation is known to {rotation}° (1σ).</p>"
    adjustment = calibration.adjustment
    text += f"<p>A corner's coordinate scatters by {adjustment.scatter_px:.3f} px"
    if adjustment.correlation > 1.5:
        factor = np.sqrt(adjustment.correlation)
        text += f"; errors of a view's corners go together, which makes every σ {factor:.1f} times as large"
    share, sigma = 100.0 * calibration.stretch, 100.0 * calibration.sigma_stretch
    if np.isfinite(sigma):
        text += f". The squares are {share:+.3f} ± {sigma:.3f} % wider than high"
    return text + ".</p>"


def _dropped_html(calibration: Calibration) -> str:
    if not calibration.dropped:
        return "<p>No view was dropped.</p>"
    return table_html(["dropped view", "reason"], [[view.name, view.reason] for view in calibration.dropped])
