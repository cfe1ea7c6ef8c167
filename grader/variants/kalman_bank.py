"""Lab 03, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm

from grader.material import variant
from grader.variants.kalman_bank_class import *  # noqa: F403  the bank of the lab
from uavlab.exercises.kalman_bank import (
    arbitrate,
    correct,
    heading_model,
    moved_reference,
    predict,
    shift_between,
    translation_model,
)
from uavlab.types import Reference, Shift

CANARY = "canary-37b5a01fdc64c616aab2e953"


@variant(translation_model)
def by_the_exponential(dt, p):
    A = expm(dt * np.eye(3, k=1))
    A[2] = (0, 0, p)
    return A, np.array([[0], [0], [1 - p]])


@variant(translation_model)
def entry_by_entry(dt, p):
    A, B = np.identity(3), np.zeros((3, 1))
    A[0, 1] = A[1, 2] = dt
    A[0, 2] = dt * dt / 2
    A[2, 2], B[2, 0] = p, 1 - p
    return A, B


@variant(heading_model)
def turn_by_lists(dt, p):
    return [[1, dt], [0, p]], [[0], [1 - p]]


@variant(heading_model)
def turn_entry_by_entry(dt, p):
    A = np.diag([1.0, p])
    A[0, 1] = dt
    return A, (1.0 - p) * np.eye(2)[:, 1:]


def covariances(*matrices):
    for M in matrices:
        if not np.allclose(M, np.transpose(M), rtol=0, atol=1e-9):
            raise ValueError("not symmetric")


@variant(predict)
def in_two_steps(x, P, u, A, B, Q):
    covariances(P, Q)
    np.linalg.cholesky(P)
    if np.min(np.linalg.eigvalsh(Q)) < -1e-9 or not math.isfinite(np.sum(x) + np.sum(u)):
        raise ValueError("no covariance, or not finite")
    half = np.dot(A, P)
    moved = np.einsum("ij,kj->ik", half, A)
    return np.dot(A, x) + np.dot(B, u), 0.5 * (moved + moved.T) + Q


@variant(predict)
def by_a_root(x, P, u, A, B, Q):
    """The covariance as the square of a moved root."""
    if not np.isfinite(np.concatenate([x, u])).all() or np.shape(Q) != np.shape(P):
        raise ValueError("not finite, or of another shape")
    covariances(P, Q)
    if np.linalg.eigvalsh(Q)[0] < -1e-9:
        raise ValueError("Q is no covariance")
    root = A @ np.linalg.cholesky(P)
    return A @ x + B @ u, root @ root.T + Q


def checked(x, P, z, H, R_z):
    if not all(np.isfinite(a).all() for a in (x, P, z, H, R_z)):
        raise ValueError("not finite")
    if np.shape(H) != (len(z), len(x)) or np.shape(R_z) != (len(z), len(z)):
        raise ValueError("shapes")
    covariances(P, R_z)
    np.linalg.cholesky(P), np.linalg.cholesky(R_z)


@variant(correct)
def simple_form(x, P, z, H, R_z):
    checked(x, P, z, H, R_z)
    nu, S = z - H @ x, H @ P @ H.T + R_z
    K = P @ H.T @ np.linalg.inv(S)
    P = (np.eye(len(x)) - K @ H) @ P
    return x + K @ nu, (P + P.T) / 2, nu.T @ np.linalg.inv(S) @ nu


@variant(correct)
def by_solving(x, P, z, H, R_z):
    checked(x, P, z, H, R_z)
    S = H @ P @ H.T + R_z
    both = np.linalg.solve(S, np.column_stack([H @ P, z - H @ x]))
    K, weighed = both[:, :-1].T, both[:, -1]
    return x + K @ (z - H @ x), P - K @ S @ K.T, float((z - H @ x) @ weighed)


@variant(correct)
def one_number_after_the_other(x, P, z, H, R_z):
    """Numbers whose noises are made independent first, then used one by one."""
    checked(x, P, z, H, R_z)
    white = np.linalg.inv(np.linalg.cholesky(R_z))
    nis = 0.0
    for number, h in zip(white @ z, white @ H, strict=True):
        Ph = P @ h
        s, nu = h @ Ph + 1.0, number - h @ x
        x, P, nis = x + Ph * nu / s, P - np.outer(Ph, Ph) / s, nis + nu * nu / s
    return x, P, nis


@variant(arbitrate)
def rule_after_rule(hypotheses, current, request):
    now = hypotheses[current]
    if request and hypotheses[request].reliable:
        return request
    best, least = current, np.inf
    for name, x in hypotheses.items():
        size = float(np.einsum("iaa->", x.P[:, :1, :1]))
        if x.reliable and size < least:
            best, least = name, size
    if now.reliable and least >= 0.5 * np.trace(np.diag([P[0, 0] for P in now.P])):
        return current
    return best


@variant(arbitrate)
def by_sorting(hypotheses, current, request):
    if current not in hypotheses or (request and request not in hypotheses):
        raise LookupError(current)
    if request and hypotheses[request].reliable:
        return request
    size = lambda name: sum(hypotheses[name].P[i][0][0] for i in range(3))  # noqa: E731
    well = sorted((name for name in hypotheses if hypotheses[name].reliable), key=size)
    if not well or (current in well and 2 * size(well[0]) >= size(current)):
        return current
    return well[0]


@variant(shift_between)
def by_complex_numbers(a, b):
    turn = np.exp(1j * (b.h[0] - a.h[0]))
    flat = complex(*b.x[:2, 0]) - turn * complex(*a.x[:2, 0])
    return Shift(np.array([flat.real, flat.imag, b.x[2, 0] - a.x[2, 0]]), float(np.angle(turn)))


@variant(shift_between)
def as_a_matrix(a, b):
    """The pose of the aircraft in b, times the inverse of that in a."""

    def pose(x):
        c, s = math.cos(x.h[0]), math.sin(x.h[0])
        return np.array([
            [c, -s, 0, x.x[0, 0]],
            [s, c, 0, x.x[1, 0]],
            [0, 0, 1, x.x[2, 0]],
            [0, 0, 0, 1],
        ])

    T = pose(b) @ np.linalg.inv(pose(a))
    return T[:3, 3], math.atan2(T[1, 0], T[0, 0])


@variant(moved_reference)
def all_vectors_at_once(reference, shift):
    c, s = math.cos(shift.heading), math.sin(shift.heading)
    vectors = np.array(reference[:4]) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    vectors[0] += shift.r
    return Reference(*vectors, reference.heading + shift.heading, reference.heading_rate)


@variant(moved_reference)
def number_by_number(reference, shift):
    c, s = np.cos(shift.heading), np.sin(shift.heading)
    turned = [[c * x - s * y, s * x + c * y, z] for x, y, z in reference[:4]]
    turned[0] = [x + t for x, t in zip(turned[0], shift.r, strict=True)]
    return (*turned, shift.heading + reference[4], reference[5])
