"""The report of a reconstruction: the matched points on the left image, the cloud in space, and its sigmas."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from rvdnav.pose.arrays import FloatArray
from rvdnav.reconstruction import Cloud
from rvdnav.report.html import figure_html, jpeg_uri, section, table_html
from rvdnav.report.page import write_page
from rvdnav.report.style import GRID, MEASURED, styled
from rvdnav.rig import Rig
from rvdnav.sequence import Frame

_DRAWN_POINTS = 15_000
"""More make a page slow."""
_SCALE = 2  # of the picture
_JPEG_QUALITY = 85
_STOPS = 12  # of the legend's colour gradient
_INK = "#808696"  # legible on a light and a dark page
_QUANTILES = (5, 50, 95)


def write_cloud_report(path: Path, name: str, cloud: Cloud, frame: Frame, rig: Rig) -> None:
    """Write the report of the reconstruction of a frame that has a left image; the same input gives the same page."""
    sections = [section("Matched points on the left image, coloured by depth", _picture(cloud, frame, rig))]
    if len(cloud):
        sections += [
            section("The cloud in W", _cloud_section(cloud)),
            section("Standard deviations", figure_html(_sigma_figure(cloud), "sigma") + _quantile_table(cloud)),
        ]
    write_page(path, name, f"stereo frame at {frame.timestamp_ns} ns", _tiles(cloud), sections)


def _tiles(cloud: Cloud) -> list[tuple[str, str, str]]:
    tiles = [("points", str(len(cloud)), f"matched, of {cloud.crossings} zero crossings in the left image")]
    if len(cloud):
        near, middle, far = np.percentile(cloud.depth, _QUANTILES)
        tiles.append(("median depth", f"{middle:.3f} m", f"5 to 95 %: {near:.3f} to {far:.3f} m"))
        half, most = np.percentile(cloud.sigma * 1e3, (50, 95))
        tiles.append(("median σ", f"{half:.2f} mm", f"95 %: {most:.2f} mm; of a point along the left camera's ray"))
        half, most = np.percentile(cloud.sigma_disparity, (50, 95))
        tiles.append(("median σ of disparity", f"{half:.3f} px", f"95 %: {most:.3f} px"))
    return tiles


def _depth_range(cloud: Cloud) -> tuple[float, float]:
    """Of the colours, m: without the few points far off."""
    low, high = np.percentile(cloud.depth, (3, 97))
    return float(low), float(max(high, low + 1e-3))


def _colours(depth: FloatArray, low: float, high: float) -> list[list[int]]:
    """BGR of depths, near to far."""
    levels = np.clip((depth - low) / (high - low), 0.0, 1.0) * 255.0
    colours: list[list[int]] = cv2.applyColorMap(levels.astype(np.uint8)[:, None], cv2.COLORMAP_TURBO)[:, 0].tolist()
    return colours


def _picture(cloud: Cloud, frame: Frame, rig: Rig) -> str:
    assert frame.left is not None
    canvas = np.repeat((frame.left.pixels * 0.6).astype(np.uint8)[:, :, None], 3, axis=2)
    canvas = canvas.repeat(_SCALE, axis=0).repeat(_SCALE, axis=1)
    legend = ""
    if len(cloud):
        low, high = _depth_range(cloud)
        pixels = np.round((rig.rect_to_raw(0, cloud.left) + 0.5) * _SCALE - 0.5).astype(int)
        for pixel, colour in zip(pixels.tolist(), _colours(cloud.depth, low, high), strict=True):
            cv2.circle(canvas, pixel, 1, colour, -1)
        legend = _legend(low, high)
    uri = jpeg_uri(canvas, _JPEG_QUALITY)
    return f'{legend}<figure class="wide"><img src="{uri}" alt="left image with matched points"></figure>'


def _legend(low: float, high: float) -> str:
    stops = ", ".join(
        f"rgb({red}, {green}, {blue})" for blue, green, red in _colours(np.linspace(low, high, _STOPS), low, high)
    )
    bar_style = f"flex: 0 1 260px; height: 10px; border-radius: 5px; background: linear-gradient(90deg, {stops})"
    style = "display: flex; gap: 10px; align-items: center"
    scale = f'{low:.3f} m <i style="{bar_style}"></i> {high:.3f} m'
    return f'<p class="legend" style="{style}">depth {scale}</p>'


def _thinned(cloud: Cloud) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Indices of at most _DRAWN_POINTS points, spread over all rows."""
    return np.unique(np.linspace(0, len(cloud) - 1, min(len(cloud), _DRAWN_POINTS)).astype(np.intp))


def _cloud_section(cloud: Cloud) -> str:
    drawn = _thinned(cloud)
    note = "x<sub>W</sub> forward, y<sub>W</sub> down, z<sub>W</sub> from the right to the left camera; drag to turn."
    if len(drawn) < len(cloud):
        note += f" {len(drawn)} of {len(cloud)} points are drawn; the file has all."
    return f'<p class="legend">{note}</p>{figure_html(_cloud_figure(cloud, drawn), "cloud")}'


def _cloud_figure(cloud: Cloud, drawn: np.ndarray[tuple[int], np.dtype[np.intp]]) -> go.Figure:
    low, high = _depth_range(cloud)
    # A hundredth of a millimetre keeps the page small.
    x, y, z = np.round(cloud.points_W[drawn], 5).T
    sigma = np.round(cloud.sigma[drawn] * 1e3, 2)
    marker = {"size": 1.6, "color": x, "colorscale": "Turbo", "cmin": low, "cmax": high}
    points = go.Scatter3d(x=x, y=y, z=z, mode="markers", marker=marker, customdata=sigma, name="")
    points.update(hovertemplate="%{x:.4f}, %{y:.4f}, %{z:.4f} m<br>σ %{customdata:.2f} mm")
    figure = styled(go.Figure(points), 620)
    # The few points far off may not shrink the rest.
    ranges = np.percentile(cloud.points_W, (0.5, 99.5), axis=0).T
    middle, reach = ranges.mean(axis=1), 0.55 * np.ptp(ranges, axis=1).clip(min=0.02)
    axes = {}
    for name, centre, half in zip("xyz", middle, reach, strict=True):
        axes[f"{name}axis"] = {
            "title": {"text": f"{name}<sub>W</sub>, m"},
            "range": [centre - half, centre + half],
            "color": _INK,
            "gridcolor": GRID,
            "showbackground": False,
            "zeroline": False,
        }
    # As the cameras see it, from behind and a little above.
    camera = {"up": {"x": 0, "y": -1, "z": 0}, "eye": {"x": -1.5, "y": -0.7, "z": 0.45}}
    figure.update_layout(
        scene={**axes, "aspectmode": "data", "camera": camera}, margin={"l": 0, "r": 0, "t": 0, "b": 0}
    )
    return figure


def _sigma_figure(cloud: Cloud) -> go.Figure:
    drawn = _thinned(cloud)
    figure = make_subplots(rows=1, cols=2, horizontal_spacing=0.1)
    # Of the logarithm, as sigmas spread over decades.
    counts, edges = np.histogram(np.log10(cloud.sigma * 1e3), bins=60)
    centres = 10.0 ** (0.5 * (edges[1:] + edges[:-1]))
    histogram = go.Scatter(x=centres, y=counts, mode="lines", line={"color": MEASURED, "shape": "hvh"}, fill="tozeroy")
    histogram.update(hovertemplate="σ %{x:.2f} mm: %{y} points<extra></extra>")
    figure.add_trace(histogram, row=1, col=1)
    scatter = go.Scattergl(
        x=np.round(cloud.depth[drawn], 4),
        y=np.round(cloud.sigma[drawn] * 1e3, 3),
        mode="markers",
        marker={"size": 3, "color": MEASURED, "opacity": 0.25},
    )
    scatter.update(hovertemplate="%{x:.3f} m: σ %{y:.2f} mm<extra></extra>")
    figure.add_trace(scatter, row=1, col=2)
    figure = styled(figure, 340)
    low, high = _depth_range(cloud)
    margin = 0.05 * (high - low)
    figure.update_layout(showlegend=False)
    figure.update_xaxes(type="log", dtick="D2", title_text="σ of a point, mm", row=1, col=1)
    figure.update_yaxes(title_text="points", row=1, col=1)
    figure.update_xaxes(title_text="depth x<sub>W</sub>, m", range=[low - margin, high + margin], row=1, col=2)
    figure.update_yaxes(type="log", dtick="D2", title_text="σ of a point, mm", row=1, col=2)
    return figure


def _quantile_table(cloud: Cloud) -> str:
    kinds = (
        ("depth, m", cloud.depth, 3),
        ("disparity, px", cloud.disparity, 2),
        ("σ of the disparity, px", cloud.sigma_disparity, 3),
        ("σ of the point, mm", cloud.sigma * 1e3, 3),
        ("correlation of the views", cloud.score, 3),
    )
    rows = [
        (label, *(f"{value:.{digits}f}" for value in np.percentile(values, _QUANTILES)))
        for label, values, digits in kinds
    ]
    return table_html(("", *(f"{quantile} %" for quantile in _QUANTILES)), rows)
