"""Monte Carlo campaigns: scenarios and sequences x faults x seeds, on one machine or on a cluster.

Needs the extra `rvdnav[campaign]`; rendering scenarios needs `rvdnav[sim]` as well.
"""

from rvdnav.campaign.plan import Plan, Source, Trial, load_plan
from rvdnav.campaign.run import Pool, run_campaign
from rvdnav.campaign.summary import Summary, summarise, upper_bound

__all__ = ["Plan", "Pool", "Source", "Summary", "Trial", "load_plan", "run_campaign", "summarise", "upper_bound"]
