"""A campaign that takes no time: what is flown is a dice."""

import os
import time

import numpy as np

from uavlab.campaigns import Campaign


def fly(seed):
    """One throw; slowly, if the environment says so."""
    time.sleep(float(os.environ.get("TOY_PAUSE", "0")))
    if seed == 13:
        raise RuntimeError("thirteen")
    x = np.random.default_rng(seed).normal(size=100)
    exit_ = "DONE" if x[0] > -1.0 else "CRASH"
    return {"exit": exit_, "mean": float(x.mean()), "norm": float(x @ np.outer(x, x) @ x)}


def die(seed):
    """The process is gone."""
    os._exit(9)


TOY = Campaign("toy", fly, {"sides": 6, "names": ("a", "b")})
