"""A campaign that takes no time: what is flown is a dice."""

import os
import time

import numpy as np
from made_flights import circle_log

from uavlab.campaigns import Campaign
from uavlab.campaigns.page import Shown
from uavlab.campaigns.summary import counted


def fly(seed):
    """One throw; slowly, if the environment says so."""
    time.sleep(float(os.environ.get("TOY_PAUSE", "0")))
    if seed == 13:
        raise RuntimeError("thirteen")
    x = np.random.default_rng(seed).normal(size=100)
    exit_ = "DONE" if x[0] > -1.0 else "CRASH"
    return {
        "exit": exit_,
        "bad": exit_ == "CRASH",
        "mean": float(x.mean()),
        "norm": float(x @ np.outer(x, x) @ x),
    }


def die(seed):
    """The process is gone."""
    os._exit(9)


def summed(rows):
    """By the sign of the mean, as far as there is one."""
    groups = lambda row: ["<high>" if row.get("mean", 0.0) > 0.0 else "low"]  # noqa: E731
    bad = [row for row in rows if row["bad"]]
    return counted(rows, "throw", groups, lambda row: row["exit"])._replace(
        said=("A dice.",), worth={"Fell off the table": bad}
    )


def shown(row):
    """A throw."""
    return Shown(f"seed {row['seed']} · {row['exit']}", {"why": row.get("reason", "")}, "")


TOY = Campaign(
    "toy", "A dice <thrown>", fly, {"sides": 6, "names": ("a", "b")},
    lambda seed: circle_log(seed=seed), summed, shown,
)  # fmt: skip
