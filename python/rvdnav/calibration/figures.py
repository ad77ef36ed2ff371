"""Figures of a calibration: residuals, errors of the views, what the views cover, and the rig in space."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from rvdnav.calibration.adjustment import T_cam_board
from rvdnav.calibration.board import Board
from rvdnav.calibration.calibrate import Calibration
from rvdnav.calibration.next_view import NextView
from rvdnav.calibration.views import SIDES
from rvdnav.camera import CameraModel
from rvdnav.pose.arrays import FloatArray
from rvdnav.report.style import GRID, MEASURED, PREDICTED, TRUE, styled

_COLOURS = (MEASURED, TRUE)
_ARROW_PX = 25.0  # the length that a residual of three times the RMS is drawn with
_OUTLINE_POINTS = 12  # a side, so that the lens bends it


def residual_figure(calibration: Calibration) -> go.Figure:
    """The corners' residuals where they are in the images, enlarged."""
    residuals = calibration.adjustment.residuals
    factor = _ARROW_PX / (3.0 * max(calibration.adjustment.rms_px, 1e-3))
    figure = _two_images(calibration, [f"{side}, residuals × {factor:.0f}" for side in SIDES])
    for camera in range(2):
        uv, r = calibration.uv[:, camera].reshape(-1, 2), residuals[:, camera].reshape(-1, 2)
        ends = np.stack([uv, uv + factor * r, np.full_like(uv, np.nan)], axis=1).reshape(-1, 2)
        line = {"color": _COLOURS[camera], "width": 1.2}
        figure.add_scatter(x=ends[:, 0], y=ends[:, 1], mode="lines", line=line, hoverinfo="skip", row=1, col=camera + 1)
        figure.add_scatter(
            x=uv[:, 0],
            y=uv[:, 1],
            mode="markers",
            marker={"color": _COLOURS[camera], "size": 3},
            customdata=np.repeat([view.name for view in calibration.views], residuals.shape[2]),
            text=[f"{np.linalg.norm(d):.3f} px" for d in r],
            hovertemplate="view %{customdata}: %{text}<extra></extra>",
            row=1,
            col=camera + 1,
        )
    return figure


def view_figure(calibration: Calibration) -> go.Figure:
    """RMS of each view in each camera."""
    figure = go.Figure()
    names = [view.name for view in calibration.views]
    for camera, side in enumerate(SIDES):
        errors = calibration.adjustment.view_rms_px[:, camera]
        figure.add_bar(x=names, y=errors, name=side, marker_color=_COLOURS[camera])
    figure.add_hline(y=calibration.adjustment.rms_px, line={"color": PREDICTED, "dash": "dot"})
    figure.update_xaxes(title_text="view", type="category")
    figure.update_yaxes(title_text="RMS of the corners, px", rangemode="tozero")
    return styled(figure, 280)


def coverage_figure(calibration: Calibration, suggested: tuple[NextView, ...]) -> go.Figure:
    """The boards' outlines in both images, those suggested for the next pictures among them."""
    figure = _two_images(calibration, list(SIDES))
    model = calibration.adjustment.model
    for camera in range(2):
        for index, T in enumerate(T_cam_board(model, camera)):
            line = {"color": _COLOURS[camera], "width": 1}
            _add_outline(
                figure, camera, model.cameras[camera], T, calibration.board, line, calibration.views[index].name
            )
        for number, view in enumerate(suggested, start=1):
            T = view.T_cam0_board if camera == 0 else model.T_cam1_cam0 @ view.T_cam0_board
            line = {"color": PREDICTED, "width": 2.5, "dash": "dash"}
            _add_outline(figure, camera, model.cameras[camera], T, calibration.board, line, f"suggested {number}")
    return figure


def tilt_figure(calibration: Calibration, suggested: tuple[NextView, ...]) -> go.Figure:
    """How the boards were tilted against the left camera's optical axis, and how far away they were."""
    figure = go.Figure()
    boards = calibration.adjustment.model.T_cam0_board
    groups = [("views", MEASURED, boards, [view.name for view in calibration.views])]
    if suggested:
        poses = np.stack([view.T_cam0_board for view in suggested])
        groups.append(("suggested", PREDICTED, poses, [str(i + 1) for i in range(len(poses))]))
    for name, colour, poses, labels in groups:
        normal = poses[:, :3, 2]
        tilt = np.degrees(np.arctan2(normal[:, :2], normal[:, 2:]))
        distance = np.linalg.norm(poses[:, :3, :3] @ calibration.board.points.mean(axis=0) + poses[:, :3, 3], axis=1)
        figure.add_scatter(
            x=tilt[:, 0],
            y=-tilt[:, 1],
            mode="markers+text",
            text=labels,
            textposition="top center",
            name=name,
            marker={"color": colour, "size": 6.0 + 8.0 * distance / distance.max()},
            customdata=distance,
            hovertemplate="%{text}: %{x:.0f}°, %{y:.0f}°, %{customdata:.2f} m<extra></extra>",
        )
    figure.update_xaxes(title_text="turned about the vertical, °", range=[-75, 75])
    figure.update_yaxes(title_text="turned about the horizontal, °", range=[-75, 75])
    return styled(figure, 420)


def rig_figure(calibration: Calibration, suggested: tuple[NextView, ...]) -> go.Figure:
    """Both cameras and all boards in the world W."""
    figure = go.Figure()
    rig = calibration.rig
    T_world_cam0 = rig.T_world_cam[0]
    model = calibration.adjustment.model
    corners = _outline(calibration.board, points=2)
    for poses, colour, name in (
        (model.T_cam0_board, GRID.replace("0.28", "0.9"), "boards"),
        (np.array([view.T_cam0_board for view in suggested]), PREDICTED, "suggested"),
    ):
        if len(poses):
            lines = [_closed(T_world_cam0, T, corners) for T in poses]
            _add_lines(figure, lines, colour, name, width=3 if name == "suggested" else 2)
    reach = 0.35 * float(np.median(model.T_cam0_board[:, 2, 3]))
    for camera, T in enumerate(rig.T_world_cam):
        lines = _frustum(rig.cameras[camera], T, reach)
        _add_lines(figure, lines, _COLOURS[camera], f"{SIDES[camera]} camera", width=4)
    axis = {"gridcolor": GRID, "showbackground": False, "zerolinecolor": GRID, "ticksuffix": " m"}
    figure.update_layout(
        scene={
            "xaxis": {**axis, "title": "x<sub>W</sub>, forward"},
            "yaxis": {**axis, "title": "y<sub>W</sub>, down"},
            "zaxis": {**axis, "title": "z<sub>W</sub>, left"},
            "aspectmode": "data",
            # Seen from behind and above the cameras, down below and left to the left.
            "camera": {"eye": {"x": -1.5, "y": -1.1, "z": -0.5}, "up": {"x": 0, "y": -1, "z": 0}},
        }
    )
    return styled(figure, 560)


def _two_images(calibration: Calibration, titles: list[str]) -> go.Figure:
    figure = make_subplots(rows=1, cols=2, subplot_titles=titles, horizontal_spacing=0.06)
    rig = calibration.rig
    figure.update_xaxes(range=[-0.5, rig.width - 0.5], constrain="domain")
    figure.update_yaxes(range=[rig.height - 0.5, -0.5], constrain="domain")
    figure.update_yaxes(scaleanchor="x", row=1, col=1)
    figure.update_yaxes(scaleanchor="x2", row=1, col=2)
    figure.update_layout(showlegend=False)
    return styled(figure, 470)


def _outline(board: Board, points: int) -> FloatArray:
    """The border (4 points, 3) of the board's squares, m, from corner to corner."""
    low, high = -board.square, board.points[-1, :2] + board.square
    corners = np.array([(low, low), (high[0], low), tuple(high), (low, high[1])])
    part = np.arange(points)[:, None] / points
    sides = [a + part * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return np.pad(np.concatenate(sides), ((0, 0), (0, 1)))


def _add_outline(
    figure: go.Figure,
    camera: int,
    model: CameraModel,
    T_cam_board: FloatArray,
    board: Board,
    line: dict[str, object],
    name: str,
) -> None:
    points = _outline(board, _OUTLINE_POINTS) @ T_cam_board[:3, :3].T + T_cam_board[:3, 3]
    uv = model.project(np.concatenate([points, points[:1]]))
    figure.add_scatter(
        x=uv[:, 0], y=uv[:, 1], mode="lines", line=line, name=name, hoverinfo="name", row=1, col=camera + 1
    )


def _closed(T_world_cam0: FloatArray, T_cam0_board: FloatArray, outline: FloatArray) -> FloatArray:
    T = T_world_cam0 @ T_cam0_board
    points: FloatArray = np.concatenate([outline, outline[:1]]) @ T[:3, :3].T + T[:3, 3]
    return points


def _frustum(camera: CameraModel, T_world_cam: FloatArray, reach: float) -> list[FloatArray]:
    w, h = camera.width - 1.0, camera.height - 1.0
    rays = camera.unproject(np.array([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]])) * reach
    corners = rays @ T_world_cam[:3, :3].T + T_world_cam[:3, 3]
    return [*(np.stack([T_world_cam[:3, 3], corner]) for corner in corners), np.concatenate([corners, corners[:1]])]


def _add_lines(figure: go.Figure, lines: list[FloatArray], colour: str, name: str, width: int) -> None:
    gap = np.full((1, 3), np.nan)
    x, y, z = np.concatenate([part for line in lines for part in (line, gap)]).T
    line = {"color": colour, "width": width}
    figure.add_scatter3d(x=x, y=y, z=z, mode="lines", line=line, name=name, hoverinfo="name")
