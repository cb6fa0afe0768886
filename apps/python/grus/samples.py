# SPDX-License-Identifier: LGPL-3.0-or-later
"""Samples without a scene file: what they are made of, and the grains that come of it."""
from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import grus._core as _core
from grus.asked import kind, whole_number
from grus.errors import InputError

Triple = Sequence[float]


def _number(name: str, value: Any, least: float = -np.inf, *, above: bool = False) -> float:
    """A finite float, of at least `least` or above it."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"{name}: expected a number, given {kind(value)}")
    number = float(value)
    if not np.isfinite(number) or number < least or (above and number == least):
        raise InputError(f"{name}: {number:g}: must be finite" +
                         ("" if least == -np.inf else f" and {'above' if above else 'at least'} {least:g}"))
    return number


def _numbers(name: str, value: ArrayLike, *shape: int) -> NDArray[np.float64]:
    """Finite numbers of a shape; -1: any length."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected numbers, given {kind(value)}") from None
    fits = array.ndim == len(shape) and all(n in (-1, m) for n, m in zip(shape, array.shape))
    if not fits or not np.isfinite(array).all():
        raise InputError(f"{name}: expected finite numbers of shape {shape}, given {kind(array)}")
    return array


def _aspect(value: ArrayLike) -> list[float]:
    """Three positive lengths, relative."""
    aspect = _numbers("aspect", value, 3)
    if not (aspect > 0).all():
        raise InputError(f"aspect: {aspect.tolist()}: lengths must be above 0")
    return list(aspect.tolist())


@dataclass(frozen=True, kw_only=True)
class Bond:
    """Bonds of the faces that Voronoi cells share.

    Args:
        modulus: of many cells (Pa)
        tension: strength (Pa)
        cohesion: strength in shear (Pa)
        fracture_energy: of opening (J/m^2)
        poissons_ratio: of many cells, 0 to 0.26
        shear_energy: fracture energy of shear (J/m^2); None: that of opening
        friction_angle: (rad)
        between: tension of bonds between clusters (Pa); 0: there are none
        damping: share of critical damping of a bond
        weibull: modulus of the strengths' scatter; 0: none
    """
    modulus: float
    tension: float
    cohesion: float
    fracture_energy: float
    poissons_ratio: float = 0.2
    shear_energy: float | None = None
    friction_angle: float = 0
    between: float = 0
    damping: float = 0
    weibull: float = 0

    def _plain(self) -> dict[str, Any]:
        plain = {key: _number(f"bond.{key}", value, 0) for key, value in asdict(self).items() if value is not None}
        for key in ("modulus", "tension", "cohesion", "fracture_energy"):
            _number(f"bond.{key}", plain[key], 0, above=True)
        if plain["poissons_ratio"] > 0.26:
            raise InputError(f"bond.poissons_ratio: {self.poissons_ratio:g}: "
                             "rigid Voronoi cells and springs of faces show 0 to 0.26")
        return plain | {"shear_energy": plain.get("shear_energy", plain["fracture_energy"])}


@dataclass(frozen=True, kw_only=True)
class Material:
    """The material of grains. Spheres and ellipsoids press by Hertz's law with Young's modulus; hulls and Voronoi cells
    by the modulus of their bond, or by `youngs_modulus`.

    Args:
        name: for what is told of it
        density: (kg/m^3)
        youngs_modulus: (Pa)
        poissons_ratio: 0 to 0.5
        friction: coefficient between grains
        rolling_friction: largest couple over normal force times effective radius
        restitution: share of the speed that an impact leaves, above 0 to 1
        damping: local, non-viscous, 0 to 1
        rotation: grains turn
        bond: of Voronoi cells
    """
    name: str = "material"
    density: float = 2650  # kg/m^3
    youngs_modulus: float = 60e9
    poissons_ratio: float = 0.25
    friction: float = 0
    rolling_friction: float = 0
    restitution: float = 1
    damping: float = 0  # local, non-viscous
    rotation: bool = True
    bond: Bond | None = None

    def _plain(self) -> dict[str, Any]:
        positive, others = ("density", "youngs_modulus", "restitution"), ("poissons_ratio", "friction",
                                                                          "rolling_friction", "damping")
        plain: dict[str, Any] = {key: _number(f"{self.name}.{key}", getattr(self, key), 0, above=key in positive)
                                 for key in positive + others}
        for key, most in (("poissons_ratio", 0.5), ("restitution", 1), ("damping", 1)):
            if plain[key] > most:
                raise InputError(f"{self.name}.{key}: {plain[key]:g}: must be at most {most:g}")
        bond = self.bond and self.bond._plain()
        return plain | {"name": str(self.name), "rotation": bool(self.rotation), "bond": bond}


@dataclass(frozen=True, kw_only=True)
class RandomPacking:
    """Grains at random places, as many as fill a share of the box.

    Args:
        radius: one (m), or the least and the largest of evenly distributed ones; of hulls that of the sphere of equal
            volume
        solid_fraction: share of the box that grains fill, at most 0.74
        count: how many; 0: as many as fill the share
        turned: orientations at random
        hulls: rounds of relaxation of the Voronoi cells that become angular grains; None: spheres
        balls: grains are balls of 32 planes, round until they break, in place of angular ones
        aspect: lengths of either along three axes, relative
        parts: (material, share, aspect) of a mixture
    """
    radius: float | tuple[float, float]
    solid_fraction: float
    count: int = 0
    turned: bool = True
    hulls: int | None = None
    balls: bool = False
    aspect: Triple = (1, 1, 1)
    parts: Iterable[tuple[int, float, Triple]] = ((0, 1, (1, 1, 1)),)

    def _plain(self) -> dict[str, Any]:
        least, most = self.radius if isinstance(self.radius, (tuple, list)) else (self.radius, self.radius)
        least = _number("radius", least, 0, above=True)
        most = _number("radius", most, least)
        fraction = _number("solid_fraction", self.solid_fraction, 0, above=True)
        if fraction > 0.74:
            raise InputError(f"solid_fraction: {fraction:g}: not even a lattice of spheres is denser than 0.74")
        parts = [{"material": whole_number("material", m, 0), "share": _number("share", s, 0, above=True),
                  "aspect": _aspect(a)} for m, s, a in self.parts]
        hulls = None if self.hulls is None else whole_number("hulls", self.hulls, 0)
        if not isinstance(self.balls, bool):
            raise InputError(f"balls: expected True or False, given {kind(self.balls)}")
        if self.balls and hulls is not None:
            raise InputError("hulls: rounds are of angular grains; balls are what they are: leave it out")
        aspect = _aspect(self.aspect)
        if aspect != [1, 1, 1] and hulls is None and not self.balls:
            raise InputError("aspect: is of angular grains and balls; ellipsoids have theirs in parts")
        return {"kind": "random", "radius": (least, most), "solid_fraction": fraction, "parts": parts, "hulls": hulls,
                "balls": bool(self.balls), "aspect": aspect, "count": whole_number("count", self.count, 0),
                "turned": bool(self.turned)}


@dataclass(frozen=True, kw_only=True)
class Lattice:
    """Equal spheres in contact; the box just holds them.

    Args:
        radius: (m)
        layers: how many along x, y and z; of "hcp" the last two even
        kind: "hcp" or "simple-cubic"
        turned: orientations at random
        material: its number in the list of materials
    """
    radius: float
    layers: tuple[int, int, int]
    kind: str = "hcp"
    turned: bool = True
    material: int = 0

    def _plain(self) -> dict[str, Any]:
        if self.kind not in ("hcp", "simple-cubic"):
            raise InputError(f'kind: {self.kind!r}: expected "hcp" or "simple-cubic"')
        layers = [whole_number("layers", n, 1) for n in self.layers]
        if len(layers) != 3 or (self.kind == "hcp" and (layers[1] % 2 or layers[2] % 2)):
            raise InputError("layers: expected three; a periodic hcp packing needs even numbers of rows and layers")
        radius, material = _number("radius", self.radius, 0, above=True), whole_number("material", self.material, 0)
        return {"kind": "lattice", "hexagonal": self.kind == "hcp", "radius": radius, "layers": layers,
                "turned": bool(self.turned), "material": material}


@dataclass(frozen=True, kw_only=True)
class Spheres:
    """Spheres at places.

    Args:
        spheres: (n, 4): x, y, z and radius (m)
        turned: orientations at random
        material: its number in the list of materials
    """
    spheres: ArrayLike
    turned: bool = True
    material: int = 0

    def _plain(self) -> dict[str, Any]:
        spheres = _numbers("spheres", self.spheres, -1, 4)
        if not (spheres[:, 3] > 0).all():
            raise InputError("spheres: radii must be above 0")
        return {"kind": "spheres", "spheres": spheres.tolist(), "turned": bool(self.turned),
                "material": whole_number("material", self.material, 0)}


@dataclass(frozen=True, kw_only=True)
class Grain:
    """One grain: a sphere of `radius`, a poly-ellipsoid of `semi_axes`, or the hull of `vertices`.

    Args:
        position: of its centre, of a hull of its mass centre, (3,) (m)
        radius: (m)
        semi_axes: along +x -x +y -y +z -z, (6,) (m)
        vertices: about `position`, (n, 3) (m)
        velocity: (3,) (m/s)
        spin: (3,) (rad/s)
        orientation: unit quaternion x y z w
        material: its number in the list of materials
    """
    position: Triple
    radius: float | None = None
    semi_axes: Sequence[float] | None = None
    vertices: ArrayLike | None = None
    velocity: Triple = (0, 0, 0)
    spin: Triple = (0, 0, 0)
    orientation: Sequence[float] = (0, 0, 0, 1)
    material: int = 0

    def _plain(self) -> dict[str, Any]:
        given = [key for key in ("radius", "semi_axes", "vertices") if getattr(self, key) is not None]
        if len(given) != 1:
            raise InputError(f"a grain has one of radius, semi_axes and vertices, not {given or 'none'}")
        axes = None
        if self.radius is not None:
            axes = [_number("radius", self.radius, 0, above=True)] * 6
        elif self.semi_axes is not None:
            axes = [_number("semi_axes", a, 0, above=True) for a in _numbers("semi_axes", self.semi_axes, 6)]
        plain = {key: _numbers(key, getattr(self, key), 3).tolist() for key in ("position", "velocity", "spin")}
        q = _numbers("orientation", self.orientation, 4)
        if abs(np.linalg.norm(q) - 1) > 1e-3:
            raise InputError("orientation: must be a unit quaternion x, y, z, w")
        vertices = None if self.vertices is None else _numbers("vertices", self.vertices, -1, 3).tolist()
        return plain | {"semi_axes": axes, "vertices": vertices, "orientation": q.tolist(),
                        "material": whole_number("material", self.material, 0)}


@dataclass(frozen=True, kw_only=True)
class Voronoi:
    """Voronoi cells that fill the box, bonded where their material has a bond.

    Args:
        cells: how many
        relax: rounds of relaxation
        clusters: that the cells are dealt to; 0: all are one
        material: its number in the list of materials
    """
    cells: int
    relax: int = 5
    clusters: int = 0
    material: int = 0

    def _plain(self) -> dict[str, Any]:
        plain = {key: whole_number(key, getattr(self, key), 0) for key in ("relax", "clusters", "material")}
        return {"kind": "voronoi", "cells": whole_number("cells", self.cells, 1)} | plain


Grains = RandomPacking | Lattice | Spheres | Voronoi | Sequence[Grain]


class Sample:
    """A periodic cell of grains, ready to be loaded: the bytes that a scene file of the same has.

    `RveSet` and `Rve` take it in place of a scene file.

    Args:
        materials: one, or a list that grains count into
        grains: RandomPacking, Lattice, Spheres, Voronoi, or a list of Grain
        box: (3,) edges (m), corner at the origin; a lattice has its own
        seed: of packing and orientations
        pressure: that it is compressed to (Pa); default: none
        friction: between grains meanwhile; default: the first material's

    Raises:
        InputError: for what cannot be made
        Unstable: where the preparation does not come to rest
    """

    def __init__(self, materials: Material | Sequence[Material], grains: Grains, *, box: Triple | None = None,
                 seed: int = 1, pressure: float | None = None, friction: float | None = None) -> None:
        self._asked = _asked(materials, grains, box, seed, pressure, friction)
        self._cells = self._variants(1)
        self._state = self._cells.prepare(0)

    def _variants(self, variants: int) -> Any:
        """For RveSet: the unit cells of seeds from this one's on."""
        return _core.Cells(self._asked, "Sample", variants)

    @property
    def state(self) -> bytes:
        """Its bytes: those of a scene file that asks for the same, but for what clocks have said of costs."""
        return self._state

    @property
    def notes(self) -> list[str]:
        """What should be known of it."""
        return self._cells.notes

    def grains(self) -> dict[str, NDArray]:
        """As RveSet.grains."""
        return _core.grains_of(self._state)

    def contacts(self) -> dict[str, NDArray]:
        """As RveSet.contacts."""
        return _core.contacts_of(self._state)

    def __repr__(self) -> str:
        return f"<grus.Sample: {len(self.grains()['id'])} grains>"


def _asked(materials: Any, grains: Any, box: Any, seed: Any, pressure: Any, friction: Any) -> dict[str, Any]:
    """All that is asked for, checked, as plain values."""
    all_materials = [materials] if isinstance(materials, Material) else list(materials)
    if not all_materials or not all(isinstance(m, Material) for m in all_materials):
        raise InputError("materials: expected a Material, or a list of them")
    if isinstance(grains, (RandomPacking, Lattice, Spheres, Voronoi)):
        plain = grains._plain()
        hulls = isinstance(grains, Voronoi) or plain.get("hulls") is not None or plain.get("balls", False)
    elif isinstance(grains, Sequence) and grains and all(isinstance(g, Grain) for g in grains):
        plain = {"kind": "listed", "grains": [g._plain() for g in grains]}
        hulls = plain["grains"][0]["vertices"] is not None
        if any((g["vertices"] is not None) is not hulls for g in plain["grains"]):
            raise InputError("grains: hulls meet hulls alone; a sample has either hulls or other shapes")
    else:
        raise InputError("grains: expected RandomPacking, Lattice, Spheres, Voronoi or a list of Grain")
    if (box is None) is not isinstance(grains, Lattice):
        raise InputError("box: is that of the lattice" if box is not None else "box: needs its edges")
    edges = None if box is None else [_number("box", edge, 0, above=True) for edge in _numbers("box", box, 3)]
    asked = {"materials": [m._plain() for m in all_materials], "hulls": hulls, "grains": plain, "box": edges,
             "pressure": None if pressure is None else _number("pressure", pressure, 0, above=True),
             "friction": all_materials[0].friction if friction is None else _number("friction", friction, 0)}
    return asked | {"record": json.dumps(asked), "seed": whole_number("seed", seed, 0)}
