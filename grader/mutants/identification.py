"""Lab 05, known wrong answers: sensors at rest. The others are in the files beside it."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from grader.mutants.identification_bench import *  # noqa: F403  (found here by their lab)
from grader.mutants.identification_drag import *  # noqa: F403  (found here by their lab)
from grader.mutants.identification_flight import *  # noqa: F403  (found here by their lab)
from uavlab.exercises import bench
from uavlab.exercises.identification import (
    accelerometer_calibration,
    gyro_bias,
)

CANARY = "canary-3162c61fd68fb74e2f06a4b1"

# gyro_bias --------------------------------------------------------------------------------------------


@sample(gyro_bias)
def gyros(rng: np.random.Generator) -> list[Arguments]:
    """At rest, with biases apart and alike; moved about one axis by a little and by more; and with a NaN."""
    drawn: list[Arguments] = []
    for axis, much, apart in ((0, 0, 1.0), (1, 0, 0.0), (1, 0.1, 1.0), (2, 0.3, 1.0), (2, 0.6, 0)):
        biases = rng.permutation((0.0, 0.4, 0.8)) + rng.uniform(0.0, 0.3, size=3)
        samples = 0.5 + apart * biases + 0.02 * rng.exponential(size=(30, 3))
        samples[10:20, axis] += much
        drawn.append((samples, 0.04))
    broken = drawn[0][0].copy()
    broken[3, 1] = np.nan
    return [*drawn, (broken, 0.04)]


def refused(samples, spread, max_std, middle):
    if not np.all(spread <= max_std):
        raise ValueError("it moved")
    return middle


@mutant(gyro_bias, hint="The bias is the mean of the readings, not their median.")
def median_taken(samples, max_std):
    return refused(samples, samples.std(axis=0), max_std, np.median(samples, axis=0))


@mutant(gyro_bias, hint="Nothing is refused: compare the standard deviation with max_std.")
def never_refused(samples, max_std):
    return samples.mean(axis=0)


@mutant(
    gyro_bias,
    hint="The variance is compared with max_std: take its square root first, the standard deviation.",
)
def variance_compared(samples, max_std):
    return refused(samples, samples.var(axis=0), max_std, samples.mean(axis=0))


@mutant(
    gyro_bias,
    hint="The spread is taken over all axes together: a bias that differs from axis to axis is no motion.",
)
def spread_of_everything(samples, max_std):
    return refused(samples, samples.std(), max_std, samples.mean(axis=0))


@mutant(
    gyro_bias,
    hint="A large bias is no motion: take the spread about the mean, not about zero.",
)
def spread_about_zero(samples, max_std):
    rms = np.sqrt((samples**2).mean(axis=0))
    return refused(samples, rms, max_std, samples.mean(axis=0))


@mutant(
    gyro_bias,
    hint="One axis that moves is enough to refuse: do not average the spreads of the axes.",
)
def spreads_averaged(samples, max_std):
    return refused(samples, samples.std(axis=0).mean(), max_std, samples.mean(axis=0))


@mutant(
    gyro_bias, hint="A NaN passes `std > max_std`, which is then False: ask `not std <= max_std`."
)
def nan_passes(samples, max_std):
    if np.any(samples.std(axis=0) > max_std):
        raise ValueError("it moved")
    return samples.mean(axis=0)


@mutant(
    gyro_bias,
    hint="The bias is what the gyro says at rest; what is added to undo it has the other sign.",
)
def bias_negated(samples, max_std):
    return -refused(samples, samples.std(axis=0), max_std, samples.mean(axis=0))


# accelerometer_calibration ----------------------------------------------------------------------------


@sample(accelerometer_calibration)
def rests(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for n in (5, 8, 12):
        R = bench.attitudes(rng, n)
        drawn.append((bench.at_rest(bench.sensor(rng), R) + 0.05 * rng.normal(size=(n, 3)), R))
    return [*drawn, (drawn[0][0][:3], drawn[0][1][:3])]


def solved(samples, force):
    """T and T b from readings and the specific forces that they should have been."""
    if len(samples) < 4:
        raise ValueError("not enough")
    M = np.column_stack((samples, -np.ones(len(samples))))
    X = np.linalg.lstsq(M, force, rcond=None)[0]
    return X[:3].T, X[3]


@mutant(
    accelerometer_calibration,
    hint="g points down here: with the scalar +9.81 all of T has the wrong sign.",
)
def g_upside_down(samples, attitudes):
    T, Tb = solved(samples, -9.81 * attitudes[:, 2])
    return T, np.linalg.solve(T, Tb)


@mutant(
    accelerometer_calibration,
    hint="The attitudes are transposed: the body sees gravity as Rᵀ g, the third row of R times 9.81.",
)
def attitudes_transposed(samples, attitudes):
    T, Tb = solved(samples, 9.81 * attitudes[:, :, 2])
    return T, np.linalg.solve(T, Tb)


@mutant(
    accelerometer_calibration,
    hint="The last row of the solution is T b, not b: solve T b = that row.",
)
def offset_not_unmixed(samples, attitudes):
    return solved(samples, 9.81 * attitudes[:, 2])


@mutant(
    accelerometer_calibration,
    hint="T is transposed: the stacked unknown is Tᵀ.",
)
def matrix_transposed(samples, attitudes):
    T, Tb = solved(samples, 9.81 * attitudes[:, 2])
    return T.T, np.linalg.solve(T, Tb)


@mutant(
    accelerometer_calibration,
    hint="The last column is −1: with +1 the offset has the wrong sign.",
)
def offset_negated(samples, attitudes):
    T, Tb = solved(samples, 9.81 * attitudes[:, 2])
    return T, -np.linalg.solve(T, Tb)


@mutant(
    accelerometer_calibration,
    hint="Gravity is counted in g: forces are in m/s², so the right side is as long as 9.81.",
)
def gravity_of_one(samples, attitudes):
    T, Tb = solved(samples, attitudes[:, 2])
    return T, np.linalg.solve(T, Tb)


@mutant(
    accelerometer_calibration,
    hint="T maps readings to forces: this fits the way back, forces to readings.",
)
def the_way_back(samples, attitudes):
    if len(samples) < 4:
        raise ValueError("not enough")
    M = np.column_stack((9.81 * attitudes[:, 2], np.ones(len(samples))))
    X = np.linalg.lstsq(M, samples, rcond=None)[0]
    return X[:3].T, X[3]


@mutant(
    accelerometer_calibration,
    hint="Too few orientations are not refused: lstsq gives some answer, of least norm. Look at the rank.",
)
def rank_ignored(samples, attitudes):
    M = np.column_stack((samples, -np.ones(len(samples))))
    X = np.linalg.lstsq(M, 9.81 * attitudes[:, 2], rcond=None)[0]
    return X[:3].T, np.linalg.lstsq(X[:3].T, X[3], rcond=None)[0]
