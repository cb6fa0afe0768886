# SPDX-License-Identifier: LGPL-3.0-or-later
"""RVEs of Gauss points."""
from __future__ import annotations

import json
import os
from typing import Any, Callable, Iterable, Iterator, Mapping, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

import grus._core as _core
from grus.asked import (Array, Named, changes_of, communicator, increments_of, path_of, room_in, settings_text,
                        state_bytes, whole_number)
from grus.errors import InputError, Unstable
from grus.samples import Sample

T = TypeVar("T")
Path = str | os.PathLike[str]


class RveSet:
    """RVEs of n Gauss points, each with a committed state and one of the last `advance`.

    Points with the same history share one RVE (the same bits as without), so a set costs what its points do
    differently.

    Args:
        scene: a cell's scene file: periodic, with its [preparation]; or a `Sample`
        n: points of this rank
        threads: over which points are spread; default: all cores of this process
        set: "KEY=VALUE" changes of the scene, as --set of grus-rve
        variant: (n,) integers: point i starts from packing.seed + variant[i]; default: all from the scene's packing
        comm: an mpi4py communicator: cells are prepared once for all ranks, an error on one is raised on all, files
            are one
        **response: keys of [rve] of grus-bvp: tangent = "automatic" (that of the contacts' stiffness),
            "contact-stiffness", "network" or "perturbation"; strain_per_step, inertial_number, unbalanced_force,
            stress_change, pressure_floor (Pa), window, max_hold, exact_sharing;
            adaptivity = {"share": s, "error": e, "elastic": x}, each off where it is absent: points whose deformation
            gradients have always been closer than s ride on one RVE; an RVE is not asked while its last answer
            foretells its stress within e of it; it answers linearly while contact forces stay within x. `report` tells
            what they save and the errors that were measured

    Raises:
        InputError: for a scene that cannot be used, with file, line and key
        Unstable: where the preparation does not come to rest
    """

    def __init__(self, scene: Path | Sample, n: int = 1, *, threads: int | None = None, set: Iterable[str] = (),
                 variant: ArrayLike | None = None, comm: Any = None, **response: Any) -> None:
        changes = changes_of(set)
        if isinstance(scene, Sample) and changes:
            raise InputError("set: is of scene files; a Sample is asked for otherwise")
        self._file = "Sample" if isinstance(scene, Sample) else path_of("scene", scene)
        n = whole_number("n", n, 0)
        team = _core.usable_cores() if threads is None else whole_number("threads", threads, 1)
        text = settings_text(response)
        start = np.zeros(n, int) if variant is None else np.asarray(variant)
        if start.shape != (n,) or start.dtype.kind not in "iu" or (n and start.min() < 0):
            raise InputError(f"variant: expected {n} integers from 0")
        self._comm, self._n = communicator(comm), n
        most = int(start.max()) if n else 0
        if comm is not None:
            most = max(comm.allgather(most))
        self._cells = self._together(lambda: scene._variants(most + 1) if isinstance(scene, Sample) else
                                     _core.Cells(self._file, changes, most + 1))
        rank, ranks = (comm.rank, comm.size) if comm is not None else (0, 1)
        mine = self._together(lambda: {v: self._cells.prepare(v) for v in range(rank, most + 1, ranks)})
        made = {
            v: state for part in (comm.allgather(mine) if comm is not None else [mine]) for v, state in part.items()
        }
        self._set = self._together(
            lambda: _core.Set(self._cells, [made[v] for v in range(most + 1)], start.tolist(), text, team))

    def __repr__(self) -> str:
        ranks = f", rank {self._comm.rank} of {self._comm.size}" if self._comm is not None else ""
        return f"<grus.RveSet of {self._file}: {self._n} points, {self.distinct} RVEs{ranks}>"

    def _together(self, work: Callable[[], T]) -> T:
        """The same outcome on all ranks: an error on one is an error on all."""
        if self._comm is None:
            return work()
        error: BaseException | None = None
        result: T | None = None
        try:
            result = work()
        except (Exception, KeyboardInterrupt) as e:
            error = e
        told = self._comm.allgather(None if error is None else (isinstance(error, ValueError), str(error)))
        if error is not None:
            raise error
        for rank, other in enumerate(told):
            if other is not None:
                raise (InputError if other[0] else Unstable)(f"rank {rank}: {other[1]}")
        return result  # type: ignore[return-value]

    def advance(self, dF: ArrayLike, stress: Array | None = None,
                tangent: Array | bool | None = None) -> tuple[Array, Array | None]:
        """Takes every point from its committed state through an increment of deformation, to rest.

        Ctrl-C stops it, and leaves the committed states.

        Args:
            dF: (n, 3, 3): F_new F_old^-1 since the last commit; det > 0; taken to 6e-11. Any order in memory; points
                may be counted by several axes, (cells, points, 3, 3), or all be in one row
            stress: where the Cauchy stress (Pa) is written: float64, (n, 6), or one row of n * 6 such as the array of a
                quadrature function; in C order; default: a new array
            tangent: the same for d(stress)/d(strain) (Pa), (n, 6, 6) or one row of n * 36; False: none

        Returns:
            Both as views: (n, 6) and (n, 6, 6), or None

        Raises:
            InputError: for what is no increment, and for an array of another shape, kind or order
            Unstable: names the point, where its grains do not come to rest or are pressed into each other
                (numerics.max_overlap), and at once where it stretches by more than 10 or less than 0.1: nothing has
                been written then, and a smaller increment may be tried
        """
        n = self._n

        def prepared() -> tuple[Array, Array, Array | None]:
            wanted = increments_of(dF, n)
            out = np.empty(6 * n) if stress is None else room_in("stress", stress, n, (6,))
            if tangent is None or isinstance(tangent, (bool, np.bool_)):
                stiffness = np.empty(36 * n) if tangent is None or tangent else None
            else:
                stiffness = room_in("tangent", tangent, n, (6, 6))
                if np.may_share_memory(out, stiffness):
                    raise InputError("tangent: shares memory with stress; one would overwrite the other")
            return wanted, out, stiffness

        wanted, out, stiffness = self._together(prepared)
        self._together(lambda: self._set.advance(wanted, out, stiffness))
        return out.reshape(n, 6), None if stiffness is None else stiffness.reshape(n, 6, 6)

    def commit(self) -> None:
        """Makes the last advance the committed states.

        Raises:
            RuntimeError: where there is none
        """
        self._together(self._set.commit)

    def __len__(self) -> int:
        return self._n

    @property
    def distinct(self) -> int:
        """RVEs that this rank has for its points."""
        return self._set.distinct

    @property
    def scene(self) -> Mapping[str, Any]:
        """The scene as used, defaults included."""
        return json.loads(self._cells.record, object_hook=lambda d: Named(f"scene of {self._file}", d))

    @property
    def notes(self) -> list[str]:
        """What should be known of the scene before it is used."""
        return self._cells.notes

    @property
    def materials(self) -> list[str]:
        """Names by the numbers in grains()["material"]."""
        return self._cells.materials

    def facts(self) -> dict[str, NDArray]:
        """Of the committed states, one number a point: grains, breakages, steps, void_ratio, work_J, energy_error (of
        the RVE's own balance), mass_kg, mass_lost_kg."""
        return Named("facts of an RVE", self._set.facts())

    def report(self) -> dict[str, Any]:
        """What the RVEs of this rank have been asked since the start, under the names of grus-bvp's summary.json:
        answers to points (asked), advances of RVEs by DEM (advanced) or instead by their last tangent (deferred) or
        linearly (elastic), points that heard another one's RVE (similar), RVEs taken along a point's own path
        (replayed), increments that needed parts (retried_in_parts), RVEs now (distinct), dem_steps; of the last commit
        worst_unbalanced_force, worst_stress_change. "errors" has for each device that is on its tolerance, how often
        its error was measured, the worst and the mean, relative to the stress: deferral when an RVE that was put off
        has gone to its place, elastic when the grains have caught up, sharing at replays, with the largest correction
        that a similar point was given; least_trust: the share of the tolerance that bad foretelling has left."""
        found = self._set.report()
        return Named("report of a set", found | {"errors": Named("errors of devices that are on", found["errors"])})

    def grains(self, i: int) -> dict[str, NDArray]:
        """Grains of point i, committed; read-only views of one snapshot: id, position (m, 3; never wrapped), velocity,
        spin, orientation (quaternion x y z w), force (N), radius (m, of the sphere of equal volume), volume, mass,
        material; where grains break generation (splits since the start) and utilisation (of the strength; NaN: not
        tested yet)."""
        return Named("grains of an RVE", self._set.grains(self._index(i)))

    def contacts(self, i: int) -> dict[str, NDArray]:
        """Touching contacts of point i, committed: a, b (rows of grains), normal (from a to b), overlap (m), force on b
        (N), branch (m, from centre to centre, images included). The stress is -sum(force branch^T) / det(cell),
        symmetrised, without bonds."""
        return Named("contacts of an RVE", self._set.contacts(self._index(i)))

    def cell(self, i: int) -> Array:
        """(3, 3): the edges of the periodic cell of point i as columns (m), committed."""
        return np.array(self._set.cell(self._index(i)))

    def _index(self, i: int) -> int:
        point = whole_number("point", i, -2 ** 31)
        if not 0 <= point < self._n:
            raise IndexError(f"point {point} of {self._n}")
        return point

    def get_state(self, i: int) -> bytes:
        """The committed state of point i, some kB a grain; the same scene, version and machine take it back, in a set
        with the same devices.

        Raises:
            InputError: with similar sharing, where a point is no state alone: use `save`
        """
        return self._set.bytes(self._index(i))

    def set_state(self, i: int, state: bytes) -> None:
        """Puts point i where a state was taken. What has advanced and is not committed is dropped, for all points.

        Raises:
            InputError: for bytes that are damaged or of another scene
        """
        self._set.restore(self._index(i), state_bytes(state))

    def _about(self) -> dict[str, Any]:
        points = self._comm.allgather(self._n) if self._comm is not None else [self._n]
        return {"program": "grus.RveSet", "points": points, "kin": self._cells.kin}

    def save(self, path: Path) -> None:
        """Writes all committed states, of all ranks, into one file (HDF5, with a checksum), whole or not at all.

        Raises:
            InputError: for what is no path
            RuntimeError: where the file cannot be written
        """
        file = self._together(lambda: path_of("path", path))
        comm, parts = self._comm, self._set.parts()
        rank, ranks = (comm.rank, comm.size) if comm is not None else (0, 1)
        about = self._about() | {"parts": comm.allgather(len(parts)) if comm is not None else [len(parts)]}

        def all_parts() -> Iterator[bytes]:
            yield from parts
            for other in range(1, ranks):
                for _ in range(about["parts"][other]):
                    yield comm.recv(source=other, tag=1)

        def send() -> None:
            if rank == 0:
                coming = all_parts()
                try:
                    return _core.write_parts(file, json.dumps(about), coming)
                finally:
                    for _ in coming:  # what a full disk did not take: the others wait until it is heard
                        pass
            for part in parts:
                comm.send(part, dest=0, tag=1)

        self._together(send)

    def load(self, path: Path) -> None:
        """Goes on from a file of `save`, with the same scene, points and ranks.

        Raises:
            InputError: for any other file; nothing is lost then
        """
        file = self._together(lambda: path_of("path", path))
        comm = self._comm
        expected = self._about()

        def read() -> list[list[bytes]]:
            text, parts = _core.read_parts(file)
            about = json.loads(text)
            if about.get("program") != "grus.RveSet":
                raise InputError(f"{file}: not written by RveSet.save")
            if about["points"] != expected["points"]:
                raise InputError(
                    f"{file}: of {about['points']} points on {len(about['points'])} ranks, here {expected['points']}")
            if about["kin"] != expected["kin"]:
                raise InputError(f"{file}: of another scene or other settings")
            ends = np.cumsum([0] + about["parts"])
            return [parts[a:b] for a, b in zip(ends, ends[1:])]

        shares = self._together(lambda: read() if comm is None or comm.rank == 0 else None)
        mine = comm.scatter(shares) if comm is not None else shares[0]  # type: ignore[index]
        self._together(lambda: self._set.load(mine))


class Rve:
    """One RVE: a set of one point, without the first axis everywhere.

    Args:
        scene: a cell's scene file, or a `Sample`
        set: "KEY=VALUE" changes of the scene
        **response: as `RveSet` takes it

    Raises:
        InputError: for a scene that cannot be used, with file, line and key
        Unstable: where the preparation does not come to rest
    """

    def __init__(self, scene: Path | Sample, *, set: Iterable[str] = (), **response: Any) -> None:
        self._rves = RveSet(scene, 1, threads=1, set=set, **response)

    def __repr__(self) -> str:
        facts = self.facts()
        return (f"<grus.Rve of {self._rves._file}: {facts['grains']} grains, {facts['breakages']} breakages, "
                f"void ratio {facts['void_ratio']:.3g}>")

    def advance(self, dF: ArrayLike, tangent: bool = True) -> tuple[Array, Array | None]:
        """Takes it from its committed state through an increment of deformation, to rest.

        Args:
            dF: (3, 3): F_new F_old^-1 since the last commit; det > 0
            tangent: whether it is asked for

        Returns:
            Cauchy stress (6,) and tangent (6, 6) or None (Pa)

        Raises:
            InputError: for what is no increment
            Unstable: as `RveSet.advance`
        """
        stress, stiffness = self._rves.advance(dF, tangent=tangent)
        return stress[0], None if stiffness is None else stiffness[0]

    def commit(self) -> None:
        """Makes the last advance the committed state."""
        self._rves.commit()

    def report(self) -> dict[str, Any]:
        """As RveSet.report."""
        return self._rves.report()

    def facts(self) -> dict[str, Any]:
        """Numbers of RveSet.facts."""
        return Named("facts of an RVE", {key: column[0].item() for key, column in self._rves.facts().items()})

    def grains(self) -> dict[str, NDArray]:
        """As RveSet.grains."""
        return self._rves.grains(0)

    def contacts(self) -> dict[str, NDArray]:
        """As RveSet.contacts."""
        return self._rves.contacts(0)

    def cell(self) -> Array:
        """(3, 3): edges as columns (m)."""
        return self._rves.cell(0)

    def get_state(self) -> bytes:
        """As RveSet.get_state."""
        return self._rves.get_state(0)

    def set_state(self, state: bytes) -> None:
        """As RveSet.set_state."""
        self._rves.set_state(0, state)

    def save(self, path: Path) -> None:
        """As RveSet.save."""
        self._rves.save(path)

    def load(self, path: Path) -> None:
        """As RveSet.load."""
        self._rves.load(path)
