"""Flights for the tests of views: made by formula, so that what must be seen is known."""

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.worlds import Worlds
from uavlab.types import Exit

ELSEWHERE = np.array([4.0, -3.0, 1.0])  # [m], where the origin lies in the world of a map


def circle_log(duration=6.0, dt=0.01, radius=3.0, exit_=Exit.DONE, reason="", **meta):
    """A coordinated circle at 2 m height, nose turning with the path; errors of a few centimetres."""
    t = np.arange(0.0, duration, dt)
    rate = 2 * np.pi / 6.0
    c, s, o = np.cos(rate * t), np.sin(rate * t), np.zeros_like(t)
    r_d = np.stack([radius * c, radius * s, o + 2.0], axis=1)
    v_d = radius * rate * np.stack([-s, c, o], axis=1)
    a_d = -radius * rate**2 * np.stack([c, s, o], axis=1)
    r = r_d + 0.15 * np.stack([np.sin(3 * t), np.cos(2 * t) - 1, 0.5 * np.sin(t)], axis=1)
    force = a_d + np.array([0, 0, 9.81])
    b3 = force / np.linalg.norm(force, axis=1, keepdims=True)
    b1 = np.cross(np.stack([-c, -s, o], axis=1), b3)
    b1 /= np.linalg.norm(b1, axis=1, keepdims=True)
    R = np.stack([b1, np.cross(b3, b1), b3], axis=2)
    share = 1.5 * 9.81 / 4 * (1 + 0.3 * np.sin(t[:, None] * [1.0, 2.0, 3.0, 4.0]))
    known = {
        "scenario": "circle", "airframe": "t650", "arm": 0.325,
        "angles": [np.pi / 4, 3 * np.pi / 4, -3 * np.pi / 4, -np.pi / 4],
        "spins": [1, -1, 1, -1], "seed": 0, "dt": dt, "mass": 1.5,
        "provenance": {"attitude_error": "mine", "TiltAxis": "stand-in"},
    }  # fmt: skip
    return Log(
        t=t, r=r, v=v_d, a=a_d, R=R, omega=np.zeros((len(t), 3)), rotors=share,
        wind=np.stack([3 + np.sin(t), o, 0.2 * np.cos(5 * t)], axis=1),
        r_e=r + 0.01, v_e=v_d, R_e=R, r_d=r_d, v_d=v_d, a_d=a_d,
        heading_d=np.arctan2(b1[:, 1], b1[:, 0]) + 0.05, heading_rate_d=o + rate,
        f_d=share.sum(axis=1), omega_d=np.zeros((len(t), 3)), solve=o + 2e-4,
        exit=exit_, reason=reason or exit_.value, meta=known | meta,
    )  # fmt: skip


AREA = {
    "border": [[-6, -7], [6, -7], [7, 0], [6, 7], [-6, 7]], "low": 0.5, "high": 6.0, "margin": 0.5, "world": "",
    "no_fly": [
        {"name": "pond", "border": [[-1, -1], [1, -1], [1, 1], [0, 0.2], [-1, 1]], "low": -np.inf, "high": np.inf},
        {"name": "tower", "border": [[4, 4], [5.5, 4], [5.5, 5.5], [4, 5.5]], "low": 0.0, "high": 3.0},
    ],
}  # fmt: skip
LATE = "the reference is 1.62 m from the estimate; bound 1.5 m"
EVENTS = [
    [0.0, "mode", "ground", "begins"], [0.0, "tracker", "Landoff", "first"],
    [0.0, "controller", "MpcController", "first"], [0.0, "limits", "slow", "first"],
    [0.5, "mode", "taking off", "asked for"], [1.5, "mode", "flying", "at its height"],
    [1.5, "tracker", "SpeedTracker", "taken over"], [2.0, "controller", "GeometricController", "taken over"],
    [2.5, "refused", "Reference", "(8.0, 0.0, 2.0) m is outside of the area"],
    [2.5, "controller", "tight", "refused: its f_d is nan"],
    [3.0, "limits", "fast", "taken over"], [4.0, "safety", "control error", LATE],
    [4.0, "mode", "emergency", LATE], [4.0, "tracker", "Landoff", "taken over"],
    [5.8, "mode", "landed", "motors off"],
]  # fmt: skip
FAULTS = [["lost", 3.2, 6.0, "gnss", 0.0], ["motor", 3.5, 4.5, "2", 0.55]]


def told_log(duration=6.0, exit_=Exit.LANDED, reason="", **meta):
    """The circle with a story: it takes off, is refused a goal, swaps, and lands in an emergency at 4 s."""
    known = {
        "scenario": "errand", "events": EVENTS, "area": AREA, "faults": FAULTS,
        "obstacles": [[-4.0, 3.0, 0.4, 4.0], [-4.5, -3.0, 0.7, 2.5]],
    }  # fmt: skip
    return circle_log(duration, exit_=exit_, reason=reason, **(known | meta))


def banked_log(duration=6.0):
    """The circle, flown on "gnss", from half time on on "map", whose world is turned by 1 rad and lies elsewhere."""
    log = circle_log(duration)
    n = len(log.t)
    late = np.arange(n) >= n // 2
    turn, r = np.where(late, 1.0, 0.0), np.where(late[:, None], ELSEWHERE, 0.0)
    eta = np.arctan2(log.R[:, 1, 0], log.R[:, 0, 0])
    there = _about_z(log.r_e, 1.0) + ELSEWHERE
    worlds = Worlds(
        ("gnss", "map"), np.where(late, 1, 0), r, turn,
        r=np.stack([log.r_e + 0.2 * log.t[:, None] / duration, there], axis=1),
        v=np.stack([log.v, _about_z(log.v, 1.0)], axis=1),
        std=np.full((n, 2, 3), 0.1), heading=np.stack([eta, eta + 1.0], axis=1),
        heading_std=np.full((n, 2), 0.02), nis=np.ones((n, 2)),
        reliable=np.stack([np.ones(n, dtype=bool), np.arange(n) >= n // 4], axis=1),
    )  # fmt: skip
    told = {
        k: np.where(late[:, None], _about_z(getattr(log, k), 1.0), getattr(log, k))
        for k in ("v_e", "v_d", "a_d")
    }
    for k in ("r_e", "r_d"):
        told[k] = np.where(
            late[:, None], _about_z(getattr(log, k), 1.0) + ELSEWHERE, getattr(log, k)
        )
    return log._replace(**told, heading_d=log.heading_d + turn, worlds=worlds)


def _about_z(x, angle):
    c, s = np.cos(angle), np.sin(angle)
    return x @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
