"""``rvdnav campaign``: many runs, on this machine or on a cluster, summed up."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from rvdnav.campaign import Pool, Summary, load_plan, run_campaign, summarise
from rvdnav.campaign.page import REPORT, write_campaign_report
from rvdnav.campaign.run import BACKENDS
from rvdnav.campaign.store import RESULTS
from rvdnav.campaign.summary import CONFIDENCE
from rvdnav.cli.tables import print_judged, print_reasons
from rvdnav.cli.terminal import console, progress_bars
from rvdnav.errors import InputError
from rvdnav.output import staged_report


def campaign(path: Path, out: Path, backend: str, scheduler: str | None, jobs: int) -> int:
    """Run the campaign that the file at ``path`` describes in the folder ``out``.

    Returns 0 if any pose was published, else 1.  Raises InputError.
    """
    if backend not in BACKENDS:
        raise InputError(f"--backend {backend}: is none of {', '.join(BACKENDS)}")
    if jobs < 1 and jobs != -1:
        raise InputError(f"--jobs {jobs}: is neither a number of trials at once nor -1")
    plan = load_plan(path)
    with progress_bars() as tell:
        rows = run_campaign(plan, out, Pool(backend, scheduler, jobs), tell)
    summary = summarise(rows)
    _print(summary)
    console.print(f"results: {out / RESULTS}", soft_wrap=True)
    with staged_report(out, REPORT) as page:
        write_campaign_report(page, plan.name, summary, rows)
    console.print(f"report: {out / REPORT}", soft_wrap=True)
    return 0 if summary.overall.published else 1


def _print(summary: Summary) -> None:
    table = Table(title="Campaign", title_justify="left")
    for heading in ("fault", "trials", "frames", "published", "wrong", "rate below"):
        table.add_column(heading, justify="left" if heading == "fault" else "right")
    for group in (*summary.by_fault, summary.overall):
        if group is summary.overall:
            table.add_section()
        table.add_row(
            group.name,
            str(group.trials),
            str(group.frames),
            f"{100 * group.availability:.1f} %",
            f"{group.wrong} of {group.judged}",
            f"{100 * group.wrong_bound:.2g} %",
        )
    console.print(table)
    console.print(
        f"rate below: of wrong poses, with {100 * CONFIDENCE:.0f} % confidence, frames taken for independent",
        soft_wrap=True,
    )
    overall = summary.overall
    print_judged(overall.judged, overall.published, "published poses")
    unpublished = overall.frames - overall.published
    print_reasons(f"Why {unpublished} of {overall.frames} frames were not published", summary.reasons)
