# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the extreme cases share: scenes from pieces, runs, results, and the list of cases."""
import json
import math
import os
import subprocess
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))
scenes = os.path.normpath(os.path.join(here, "..", "..", "apps", "scenes"))
cases = []
binaries = ""


def case(title, holds, slow=False):
    """Registers a case: a function of a scratch folder that returns (measured, passed)."""
    def add(f):
        cases.append({"title": title, "holds": holds, "slow": slow, "run": f, "name": f.__name__})
        return f
    return add


class Run:
    """One run of a program on a scene text or file."""

    def __init__(self, tmp, scene, *sets, program="grus-rve", threads=1, timeout=900):
        self.folder = tempfile.mkdtemp(dir=tmp) + "/out"
        if "\n" in scene:
            path = os.path.join(os.path.dirname(self.folder), "scene.toml")
            with open(path, "w") as f:
                f.write(scene)
        else:
            path = os.path.join(scenes, scene)
        command = [os.path.join(binaries, program), path, "-o", self.folder, "--quiet", "--threads", str(threads)]
        for s in sets:
            command += ["--set", s]
        try:
            r = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
            self.exit, self.error = r.returncode, r.stderr.strip()
        except subprocess.TimeoutExpired:
            self.exit, self.error = -1, f"still running after {timeout} s"

    def __getattr__(self, name):
        if name == "columns":
            sys.path.insert(0, os.path.join(binaries, "..", "python"))
            from grus.results import read_history
            self.columns = read_history(self.folder)
            return self.columns
        if name == "summary":
            with open(os.path.join(self.folder, "summary.json")) as f:
                self.summary = json.load(f)
            return self.summary
        raise AttributeError(name)

    def last(self, column):
        return self.columns[column][-1]

    @property
    def energy(self):
        return self.summary["errors"]["worst_energy_error"]

    @property
    def finite(self):
        """No column holds anything but numbers."""
        try:
            return all(math.isfinite(v) for values in self.columns.values() for v in values)
        except ValueError:  # stopped before the first row
            return True

    @property
    def mass(self):
        """Relative gain of mass, fines counted."""
        m = self.summary["mass"]
        return (m["grains_kg"] + m["lost_kg"]) / m["start_kg"] - 1

    def stopped(self, *words):
        """Ended with status 3, one line that says why, and results kept."""
        return self.exit == 3 and self.error.count("\n") == 0 and all(
            w in self.error for w in words) and os.path.exists(self.folder + "/history.csv") and self.finite

    def refused(self, *words):
        """Refused with one line; nothing created."""
        return self.exit == 2 and self.error.count("\n") == 0 and all(
            w in self.error for w in words) and not os.path.exists(self.folder)


def material(youngs=60e9, density=2650, poisson=0.25, extra=""):
    return f"[material.m]\nyoungs_modulus = {youngs!r}\ndensity = {density!r}\npoissons_ratio = {poisson!r}\n{extra}\n"


def sphere(radius, position, velocity=(0, 0, 0), name="m", spin=(0, 0, 0)):
    return (
        f"[[grain]]\nshape = \"sphere\"\nradius = {radius!r}\nposition = {list(map(float, position))}\n"
        f"velocity = {list(map(float, velocity))}\n"
        f"spin = {list(map(float, spin))}\nmaterial = \"{name}\"\n")


def free(duration, rows=20):
    return (f"[boundary]\nkind = \"open\"\n[loading]\nkind = \"free\"\nduration = {duration!r}\n[output]\n"
            f"history_interval = \"{duration / rows!r} s\"\n")


def contact_time(radius, youngs, poisson, density, speed):
    """Hertz's contact time of two equal spheres that meet at a relative speed."""
    k = 4 / 3 * youngs / (2 * (1 - poisson ** 2)) * math.sqrt(radius / 2)
    m = density * 4 / 3 * math.pi * radius ** 3 / 2
    return 2.9432751843247047 / speed * (5 * m * speed ** 2 / (4 * k)) ** 0.4


def collision(radius=0.01, youngs=60e9, poisson=0.25, density=2500, speed=2.0, extra="", tail=""):
    """Two equal spheres that meet; three contact times."""
    t = contact_time(radius, youngs, poisson, density, speed)
    gap = 0.2 * speed * t
    z = radius + gap / 2
    return (material(youngs, density, poisson, extra) + sphere(radius, (0, 0, -z), (0, 0, speed / 2)) +
            sphere(radius, (0, 0, z), (0, 0, -speed / 2)) + free(4 * t) + tail)


def cell(extra="", packing_seed=3, loading="", count=120, box=0.003, youngs=60e9, pressure=1e6, numerics="",
         fracture=""):
    """A periodic cell of some 120 grains of 0.2 to 0.4 mm, brought to a pressure."""
    return (
        material(youngs, 2650, 0.17, "friction = 0.5\nrestitution = 0.5\ndamping = 0.2\n" + extra) + fracture +
        f"[packing]\nkind = \"random\"\nbox = [{box!r}, {box!r}, {box!r}]\n"
        f"radius = {{ distribution = \"uniform\", min = 0.0002, max = 0.0004 }}\n"
        f"solid_fraction = 0.56\nseed = {packing_seed}\n[boundary]\nkind = \"periodic\"\n"
        f"[preparation]\npressure = {pressure!r}\nfriction = 0.2\ninertial_number = 5e-3\n{loading}\n[numerics]\n"
        f"max_overlap = 0.5\n{numerics}\n"
    )


def uniaxial(strain, rate, rows=50):
    return (f"[loading]\nkind = \"uniaxial-strain\"\naxis = \"z\"\nstrain_rate = {rate!r}\nfinal_strain = {strain!r}\n"
            f"[output]\nhistory_interval = {strain / rows!r}\n")
