# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bands of shear between two frames of a macro problem: how much of the body takes part, and how wide a band is."""
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grus.errors import InputError
from grus.frames import Frame


def _brick(corners: list[tuple[int, ...]]) -> tuple[NDArray, float]:
    """Gradients of the shape functions at the centre of a unit brick, and its size."""
    return (2.0 * np.array(corners) - 1) / 2**(len(corners[0]) - 1), 1.0


def _simplex(dimensions: int) -> tuple[NDArray, float]:
    """Those of a simplex, which are the same everywhere."""
    return np.vstack([-np.ones(dimensions), np.eye(dimensions)]), 1 / math.factorial(dimensions)


# By VTK's number of the kind of element: gradients on the reference element (corners, dimensions), and its size.
_ELEMENTS = {
    5: _simplex(2),
    9: _brick([(0, 0), (1, 0), (1, 1), (0, 1)]),
    10: _simplex(3),
    12: _brick([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]),
}
CONTRAST = 1.5  # below this ratio of a profile's peak to its level beside it nothing is called a band


class ShearBand(NamedTuple):
    """What has sheared between two frames.

    Attributes:
        fraction: of the body that takes part: (integral of g)^2 / (volume x integral of g^2), g the shear strain;
            1: an even strain, w/L: one band of width w across a body of length L along the band's normal
        width: of the strongest band (m), in the shape before any load: at half of its height above what is beside it.
            NaN in three dimensions, and where no band stands out
        angle: between the band and the x axis (degrees, 0 to 180); NaN with the width
        peak: largest g of a profile across the band; NaN with the width
    """
    fraction: float
    width: float
    angle: float
    peak: float


def shear_strain(first: Frame, last: Frame) -> NDArray:
    """Shear strain of each element between two frames, sqrt(2 e:e), (cells,): e is the deviator of the Hencky strain at
    the centre of the element. Of simple shear it is the shear angle, while that is small.

    Raises:
        InputError: where the frames are of different meshes, or not of a macro problem
    """
    for f in (first, last):
        if "displacement_m" not in f.at_points:
            raise InputError(f"{f.path}: no displacement: not a frame of a macro problem")
    if len(first.connectivity) != len(last.connectivity) or not np.array_equal(first.points, last.points):
        raise InputError(f"{last.path}: another mesh than {first.path}")
    corners, gradients, _ = _elements(first)
    before, after = (np.einsum("cki,ckj->cij", f.points[corners].astype(np.float64) +
                               f.at_points["displacement_m"][corners], gradients) for f in (first, last))
    if gradients.shape[2] == 2:  # plane: nothing is stretched across
        before, after = (np.pad(f[:, :2, :2], ((0, 0), (0, 1), (0, 1))) for f in (before, after))
        before[:, 2, 2] = after[:, 2, 2] = 1
    stretch = after @ np.linalg.inv(before)
    log = np.log(np.linalg.eigvalsh(np.swapaxes(stretch, 1, 2) @ stretch)) / 2
    deviator = log - log.mean(axis=1, keepdims=True)
    return np.sqrt(2 * (deviator**2).sum(axis=1))


def shear_band(first: Frame, last: Frame) -> ShearBand:
    """Finds what has sheared between two frames of a macro problem.

    In two dimensions the shear strain is averaged along lines of every angle. The band is the line whose mean is the
    largest of all that cross half of the body or more.

    Raises:
        InputError: where the frames are of different meshes, or not of a macro problem
    """
    g = shear_strain(first, last)
    corners, gradients, volume = _elements(first)
    total = volume.sum()
    squares = (volume * g**2).sum()
    fraction = (volume * g).sum()**2 / (total * squares) if squares > 0 else 1.0
    if gradients.shape[2] == 3:
        return ShearBand(float(fraction), np.nan, np.nan, np.nan)
    return ShearBand(float(fraction), *_across(first.points[corners].mean(axis=1)[:, :2], volume, g))


def _elements(frame: Frame) -> tuple[NDArray, NDArray, NDArray]:
    """Corners of each element (cells, corners), the gradients of their shape functions at its centre with respect to
    the place before any load (cells, corners, dimensions), and its size (cells,): of bricks by the Jacobian there."""
    kinds = set(frame.types.tolist())
    if len(kinds) != 1 or not kinds <= set(_ELEMENTS):
        raise InputError(f"{frame.path}: elements of the kinds {sorted(kinds)}: not a frame of a macro problem")
    local, size = _ELEMENTS[kinds.pop()]
    count, dimensions = local.shape
    corners = frame.connectivity.reshape(-1, count)
    x = frame.points[corners].astype(np.float64)[:, :, :dimensions]
    jacobian = np.einsum("cki,kj->cij", x, local)
    return corners, np.einsum("kj,cji->cki", local, np.linalg.inv(jacobian)), size * np.abs(np.linalg.det(jacobian))


def _across(x: NDArray, area: NDArray, g: NDArray) -> tuple[float, float, float]:
    """(width, angle, peak) of the strongest band: profiles of g over the distance from lines of every angle."""
    best, at_angle = np.zeros(1), 0.0
    step = np.sqrt(area.mean()) / 2
    for angle in range(180):
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        profile = _profile(x @ normal, np.sqrt(area), area, g, step)
        if profile.max() > best.max():
            best, at_angle = profile, float(angle)
    at, peak, beside = int(best.argmax()), best.max(), np.quantile(best, 0.25)
    if peak <= CONTRAST * beside:
        return np.nan, np.nan, np.nan
    half = (peak + beside) / 2
    ways = np.array([_until(best[at:], half), _until(best[at::-1], half)])
    ways = ways[np.isfinite(ways)]  # where a band runs along the surface it is told as if it went on there
    return float(2 * step * ways.mean()), at_angle, float(peak)


def _profile(d: NDArray, size: NDArray, area: NDArray, g: NDArray, step: float) -> NDArray:
    """Means of g over distance d, by steps, each element in two halves; where half of the longest line is crossed."""
    halves = np.concatenate([d - size / 4, d + size / 4])
    at = ((halves - (d - size / 2).min()) / step).astype(int)
    weights, sums = np.bincount(at, np.tile(area, 2)), np.bincount(at, np.tile(area * g, 2))
    long = weights >= weights.max() / 2
    return sums[long] / weights[long]


def _until(profile: NDArray, level: float) -> float:
    """How many steps from its start a profile takes to fall to a level; infinite where it does not."""
    below = np.flatnonzero(profile < level)
    if not len(below):
        return np.inf
    k = int(below[0])
    return k - 1 + float((profile[k - 1] - level) / (profile[k - 1] - profile[k]))
