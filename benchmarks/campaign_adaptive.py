"""Adaptive search against uniform sampling at the same budget, on a shipped campaign.

python -m benchmarks.campaign_adaptive [--campaign campaigns/valve_bits_search] [--runs 600] [--seeds 1 2] [--out DIR]
Goal: at least 10 times as many hazardous runs per 1 000. Prints the table of docs/campaigns.md; a benchmark that was
stopped goes on where it was.
"""

import argparse
from pathlib import Path

from bench.campaign.engine import CampaignRun, read_campaign
from bench.campaign.statistics import Share, share
from bench.campaign.store import read_rows
from bench.scenario.locate import find_scenario

GOAL = 10.0


def hazardous(path: Path, kind: str, runs: int, seed: int, folder: Path) -> Share:
    """Share of hazardous runs of a strategy."""
    campaign = read_campaign(path)
    strategy = campaign.strategy.model_copy(update={"kind": kind, "runs": runs, "seed": seed})
    changed = campaign.model_copy(update={"strategy": strategy})
    CampaignRun(changed, path, folder).run()
    outcomes = [row["outcome"] for row in read_rows(folder) if not row["fault_free"]]
    return share(outcomes.count("hazardous"), len(outcomes))


def main() -> None:
    """Print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaign", default="campaigns/valve_bits_search")
    parser.add_argument("--runs", type=int, default=600)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--out", type=Path, default=Path("runs") / "campaigns" / "adaptive-benchmark")
    arguments = parser.parse_args()
    path = find_scenario(arguments.campaign)
    gains = []
    print("| seed of the choice | strategy | runs | hazardous | per 1 000 runs, 95 % interval | gain |")
    print("|---|---|---|---|---|---|")
    for seed in arguments.seeds:
        found = {
            kind: hazardous(path, kind, arguments.runs, seed, arguments.out / f"{kind}-{seed}")
            for kind in ("sampled", "adaptive")
        }
        gains.append(found["adaptive"].value / max(found["sampled"].value, 1.0 / arguments.runs))
        for kind, value in found.items():
            gain = f"{gains[-1]:.1f}" if kind == "adaptive" else ""
            interval = f"{1000 * value.value:.0f} [{1000 * value.low:.0f}, {1000 * value.high:.0f}]"
            print(f"| {seed} | {kind} | {value.total} | {value.count} | {interval} | {gain} |", flush=True)
    print(f"\nsmallest gain {min(gains):.1f}: goal {GOAL:g} {'reached' if min(gains) >= GOAL else 'missed'}")


if __name__ == "__main__":
    main()
