"""Error budgets: how far the pose may err over range and viewing angle, from which causes, and what must improve."""

from rvdnav.budget.assumptions import Assumptions
from rvdnav.budget.budget import Budget, draw_up
from rvdnav.budget.check import Check, check
from rvdnav.budget.design import Design
from rvdnav.budget.levers import Change, changes
from rvdnav.budget.page import write_budget
from rvdnav.budget.propagation import PoseBudget, pose_budget
from rvdnav.budget.requirement import Improvement, Requirement, improvement, parse_requirement
from rvdnav.budget.sweep import Cell, Sigma, Sweep, cell, sweep

__all__ = [
    "Assumptions",
    "Budget",
    "Cell",
    "Change",
    "Check",
    "Design",
    "Improvement",
    "PoseBudget",
    "Requirement",
    "Sigma",
    "Sweep",
    "cell",
    "changes",
    "check",
    "draw_up",
    "improvement",
    "parse_requirement",
    "pose_budget",
    "sweep",
    "write_budget",
]
