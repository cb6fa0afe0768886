# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the tests of values share: a table of what was held against what, runs, frames of grains and of contacts."""
import csv
import json
import os
import subprocess

import h5py
import numpy as np

from scene_tools import need


class Values:
    """Of each name (KIND:NAME) whether a number was held against an expectation that tells signs and factors apart."""

    def __init__(self, binaries, folder):
        self.binaries, self.folder, self.held, self.told = binaries, folder, {}, set()

    def same(self, name, got, expected, rtol=1e-6, atol=0.0):
        """Numbers, or arrays of them. Held only if the tolerance is small beside the largest that is expected."""
        try:
            got, expected = np.broadcast_arrays(np.asarray(got, float), np.asarray(expected, float))
        except ValueError as mismatch:
            need(False, f"{name}: {mismatch}")
            return
        largest = np.abs(expected).max(initial=0)
        near = np.abs(got - expected) <= atol + rtol * np.abs(expected)
        if not need(near.all() and near.size > 0, f"{name}: {got[~near][:4]} where {expected[~near][:4]} is expected"):
            return
        if largest > 0 and atol + rtol * largest < 0.25 * largest:
            self.held[name] = self.held.get(name, 0) + near.size

    def run(self, program, name, text, *sets, files=()):
        """A run of one thread: Run. Its names are those that must be held."""
        out = os.path.join(self.folder, name)
        os.makedirs(out + ".d", exist_ok=True)
        for file, content in (("scene.toml", text), *files):
            with open(os.path.join(out + ".d", file), "w") as f:
                f.write(content)
        command = [os.path.join(self.binaries, f"grus-{program}"), os.path.join(out + ".d", "scene.toml"), "-o", out]
        command += ["--quiet", "--threads", "1", *[a for s in sets for a in ("--set", s)]]
        r = subprocess.run(command, capture_output=True, text=True, timeout=100)
        need(r.returncode == 0, f"{name}: exit {r.returncode} {r.stderr}")
        done = Run(program, out)
        self.told |= done.names()
        return done

    def balance(self, run, *names, least=20):
        """Energies of history.csv, of which each is `least` times larger than what their balance lacks at the end."""
        last, told = run.last, run.told["energy"]
        put = told["start_J"] + last["work_J"] + last.get("reshape_J", told["reshape_J"]) + last.get("inertia_J", 0)
        taken = sum(last.get(f"{k}_J", 0) for k in ("kinetic", "elastic", "friction", "damping", "fracture", "split",
                                                     "adhesion"))
        lacks = put - taken - last.get("handed_J", told["handed_J"])
        scale = max(np.abs(run.columns["work_J"]).max(), last["kinetic_J"] + last["elastic_J"], told["start_J"])
        self.same("rve.columns:energy_error", last["energy_error"], lacks / scale, rtol=1e-3, atol=1e-9)
        for name in names:
            self.same(f"rve.columns:{name}", last[name], last[name] - lacks, rtol=1 / least)


class Run:
    """What a run has written."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        self.columns = table(os.path.join(folder, "history.csv"))
        self.last = {k: v[-1] for k, v in self.columns.items()}
        with open(os.path.join(folder, "summary.json")) as f:
            self.told = json.load(f)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def series(self, what):
        with open(self.path(f"{what}.hdf.series")) as f:
            return [x["name"] for x in json.load(f)["files"]]

    def frames(self, what="grains"):
        return [Frame(self.path(name)) for name in self.series(what)]

    def names(self):
        """KIND:NAME of each number that the run tells."""
        names = {f"{self.program}.columns:{k}" for k in self.columns}
        names |= {f"{self.program}.summary:{k}" for k in leaves(self.told)}
        for file in ("grading", "broken_bonds", "bursts", "hopkinson", "costs"):
            if os.path.exists(self.path(file + ".csv")):
                with open(self.path(file + ".csv"), newline="") as f:
                    names |= {f"{self.program}.{file}:{k}" for k in next(csv.reader(f))}
        for what in ("grains", "contacts", "macro"):
            if os.path.exists(self.path(f"{what}.hdf.series")):
                names |= {f"{self.program}.{what}:{k}" for k in self.frames(what)[-1].fields}
        return names


def table(path):
    with open(path, newline="") as f:
        rows = list(csv.reader(f))
    return dict(zip(rows[0], np.array([[float(x) for x in row] for row in rows[1:]]).reshape(-1, len(rows[0])).T))


# Of these what is below them is not told as numbers of the run.
PLAIN = ("scene", "unit_cell", "notes", "files", "last_row")


def leaves(told, at=""):
    """Paths of what a summary tells; of lists without their places."""
    for key, value in told.items():
        path = f"{at}.{key}" if at else key
        if isinstance(value, dict) and path not in PLAIN:
            yield from leaves(value, path)
        else:
            yield path


class Frame:
    """A VTKHDF file: points, fields of cells and points, and of grains what their triangles say."""

    def __init__(self, path):
        with h5py.File(path, "r") as f:
            grid = f["VTKHDF"]
            self.points = grid["Points"][:].astype(float)
            self.connectivity, self.offsets, self.types = (grid[k][:] for k in ("Connectivity", "Offsets", "Types"))
            self.cells = {k: v[:].astype(float) for k, v in grid["CellData"].items()}
            self.nodes = {k: v[:].astype(float) for k, v in grid.get("PointData", {}).items()}
        self.fields = {**self.cells, **self.nodes}

    def grains(self):
        """Fields of each grain, by its id; its centre as `centre`, its points as `points`."""
        drawn = np.flatnonzero(self.types == 5)
        ids, first, owner = np.unique(self.cells["id"][drawn], return_index=True, return_inverse=True)
        corners = self.connectivity[self.offsets[drawn][:, None] + np.arange(3)]
        of = {k: v[drawn][first] for k, v in self.cells.items()}
        of["points"] = [self.points[np.unique(corners[owner == k])] for k in range(len(ids))]
        of["centre"] = np.array([0.5 * (p.min(0) + p.max(0)) for p in of["points"]])
        return of

    def lines(self):
        """Corners of the outline of cell or box: the first, and its edges as columns."""
        drawn = np.flatnonzero(self.types == 3)
        corners = self.points[np.unique(self.connectivity[self.offsets[drawn][:, None] + np.arange(2)])]
        return corners[0], np.stack([corners[k] - corners[0] for k in (1, 2, 4)], 1)

    def branches(self):
        """Begin and end of each contact's line."""
        ends = self.points[self.connectivity].reshape(-1, 2, 3)
        return ends[:, 0], ends[:, 1]


def voigt(m):
    return np.array([m[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))])


PARTS = ("xx", "yy", "zz", "yz", "xz", "xy")
