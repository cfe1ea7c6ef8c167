"""Flights for the tests of views: made by formula, so that what must be seen is known."""

import numpy as np

from uavlab.flight.log import Log
from uavlab.types import Exit


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
