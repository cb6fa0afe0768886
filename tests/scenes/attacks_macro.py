#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What breaks grus-bvp under attack: attacks_macro.py BIN"""
import math
import os
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from attack_tools import MATERIAL, UNIAXIAL, bvp, interrupted, limited, refused
from scene_tools import faults, history, need, run, shipped, summary, write

ELASTIC = (
    "[mesh]\nbox = { size = [0.01, 0.1], cells = [1, 20] }\ndimension = \"axisymmetric\"\n[[region]]\nwhere = \"y<1\"\n"
    "material = \"elastic\"\nyoungs_modulus = \"200 GPa\"\n"
    "poissons_ratio = 0.3\ndensity = 7800\n[[boundary]]\nwhere = \"x=min\"\ndisplacement = [0, \"free\"]\n")
BAR = ELASTIC + (
    "[[boundary]]\nwhere = \"y=min\"\npressure = \"100 MPa\"\nhistory = \"constant\"\n[[probe]]\nname = \"a\"\n"
    "at = [0.005, 0.03]\n[[probe]]\nname = \"b\"\nat = [0.005, 0.07]\n"
    "[hopkinson]\nincident_gauge = \"a\"\ntransmitted_gauge = \"b\"\nincident_distance = 0.02\n"
    "transmitted_distance = 0.02\nbar_modulus = \"200 GPa\"\nbar_density = 7800\nbar_area = 3.14e-4\n"
    "specimen_length = 0.01\nspecimen_area = 3.14e-4\n[solve]\nkind = \"explicit-dynamic\"\nduration = \"40 us\"\n")
CELL = (
    "[packing]\nkind = \"simple-cubic\"\nradius = { distribution = \"constant\", mean = \"0.3 mm\" }\n"
    "layers = [3, 3, 3]\n[boundary]\nkind = \"periodic\"\n"
    "[preparation]\npressure = \"1 MPa\"\n")


def macro(tmp):
    """grus-bvp: bars without grains, locking, meshes that lie about their size, cells whose scene has a mistake."""
    if not bvp:
        return
    out = os.path.join(tmp, "bar")
    r = run(bvp, write(tmp, BAR), "-o", out, "--quiet")
    need(r.returncode == 0 and r.stderr == "", f"a bar without grains: exit {r.returncode} {r.stderr!r}")
    need("specimen_strain" not in open(os.path.join(out, "hopkinson.csv")).readline() and summary(out)["status"] == 0,
         "hopkinson.csv of a bar without grains")
    need("yy" in run(bvp, write(tmp, BAR), "-o", out, "--force").stdout,
         "progress of a two-dimensional run shows the hoop")
    squeeze = ("[[boundary]]\nwhere = \"y=max\"\ndisplacement = [\"free\", \"-0.01 mm\"]\n[[boundary]]\n"
               "where = \"y=min\"\ndisplacement = [\"free\", 0]\n[solve]\nkind = \"quasi-static\"\nincrements = 1\n")
    for nu, order, said in ((0.49, 1, True), (0.49, 2, False), (0.3, 1, False)):
        r = run(
            bvp,
            write(tmp, (ELASTIC + squeeze).replace("poissons_ratio = 0.3", f"poissons_ratio = {nu}") +
                  f"[element]\norder = {order}\n"), "--check")
        need(r.returncode == 0 and ("lock" in r.stdout and "element.order = 2" in r.stdout) == said,
             f"locking at {nu}, order {order}: {r.stdout!r}")
    begin = time.time()
    mesh = write(tmp, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 999999999 1 9\n2 1 0 999999999\n", "huge.msh")
    scene = (ELASTIC + squeeze).replace('box = { size = [0.01, 0.1], cells = [1, 20] }', f'file = "{mesh}"')
    out = os.path.join(tmp, "mesh")
    r = subprocess.run([bvp, write(tmp, scene), "-o", out], capture_output=True, text=True,
                       preexec_fn=limited(resource.RLIMIT_AS, 2 << 30), timeout=60)
    need(r.returncode == 2 and "more than the file can hold" in r.stderr and time.time() - begin < 10,
         f"a mesh of 999999999 nodes in 60 bytes: exit {r.returncode} {r.stderr!r}")
    write(tmp, "root:secret:0:0\n", "huge.msh")
    r = run(bvp, write(tmp, scene), "-o", out)
    need(r.returncode == 2 and "secret" not in r.stderr and r.stderr.count("\n") == 1,
         f"a file that is no mesh is quoted: {r.stderr!r}")
    # Cells: mistakes in parts of their scene that are not used here show all the same.
    block = (
        "[mesh]\nbox = { size = [0.01, 0.01, 0.01], cells = [1, 1, 1] }\n[rve]\nscene = \"cell.toml\"\n[[boundary]]\n"
        "where = \"z=max\"\ndisplacement = [0, 0, \"-0.02 mm\"]\n"
        "[[boundary]]\nwhere = \"z=min\"\ndisplacement = [0, 0, 0]\n[solve]\nkind = \"quasi-static\"\nincrements = 1\n"
        "tolerance = 1e-9\n[output]\nframes = 100000\n"
    )
    for bad, word in (("[loading]\nkind = \"uniaxial-strain\"\nstrain_rat = 1.0\n", "strain_rat"),
                      ("[output]\nframs = 2\n", "frams"), ("[loading]\nkind = \"uniaxial\"\n", "uniaxial-strain")):
        write(tmp, MATERIAL + CELL + bad, "cell.toml")
        refused(tmp, block, "cell.toml", word, program=bvp)
    write(tmp, MATERIAL + CELL + UNIAXIAL, "cell.toml")
    r = run(bvp, write(tmp, block), "--check")
    need(
        r.returncode == 0 and "residual to 0.001" in r.stdout and "not to solve.tolerance" in r.stdout
        and "output.frames = 100000" in r.stdout, f"what binds is not said: {r.stdout!r} {r.stderr!r}")
    # Grains of 0.6 mm in elements of 0.5 mm: an RVE has no place in an element, only in the whole body.
    r = run(bvp, write(tmp, block), "--check", "--set", "mesh.box.cells=[1, 1, 20]")
    need(r.returncode == 0 and "in metres?" not in r.stdout, f"elements below a grain: {r.stdout!r} {r.stderr!r}")
    out = os.path.join(tmp, "block")
    r = run(bvp, write(tmp, block.replace("frames = 100000", "frames = 1")), "-o", out, "--quiet")
    errors = summary(out)["errors"] if r.returncode == 0 else {}
    need(
        errors.get("residual_floor") == 1e-3 and 0 <= errors.get("hill_mandel", -1) < 0.2,
        f"errors: {errors} {r.stderr!r}")
    # Cells of a frame without grains have no void ratio: NaN (a small data set is stored as it is).
    half = block.replace("cells = [1, 1, 1]", "cells = [1, 1, 2]").replace(
        "frames = 100000", "frames = 1"
    ) + "[[region]]\nwhere = \"z<0.005\"\nmaterial = \"elastic\"\nyoungs_modulus = \"1 GPa\"\npoissons_ratio = 0.2\n"
    out = os.path.join(tmp, "half")
    r = run(bvp, write(tmp, half), "-o", out, "--quiet")
    frame = open(os.path.join(out, "macro", "macro_00000.hdf"), "rb").read() if r.returncode == 0 else b""
    need(
        frame.count(struct.pack("<f", math.nan)) == 3,
        f"void ratio, broken fraction and grains of an elastic cell: {frame.count(struct.pack('<f', math.nan))} NaN "
        f"{r.stderr}"
    )
    # One rank needs no folder of Open MPI 4: runs beside one another would share it. Version 5 must have one.
    r = subprocess.run([bvp, "--version"], capture_output=True, text=True, env=dict(os.environ, TMPDIR="/proc/none"))
    fifth = "(Open MPI) 5" in run("mpirun", "--version").stdout
    need(fifth or r.returncode == 0 and r.stderr == "", f"no temporary files: {r.returncode} {r.stderr[:99]}")
    # A full disk: one line, the status told where there is room for it.
    out = os.path.join(tmp, "full")
    tight = {
        "preexec_fn": limited(resource.RLIMIT_FSIZE, 25000), "env": dict(os.environ, PMIX_MCA_gds="hash",
                                                                         OMPI_MCA_btl="self")
    }  # MPI's own files stay small
    r = subprocess.run([bvp, write(tmp, half), "-o", out, "--quiet", "--set", "output.checkpoint_interval=1e-9"],
                       capture_output=True, text=True, timeout=60, **tight)
    # Here what is prepared is too large already: nothing has run that could be told of.
    need(
        r.returncode == 1 and "cannot write" in r.stderr and r.stderr.count("\n") == 1
        and not any(f.endswith(".new") for f in os.listdir(out)), f"full disk: exit {r.returncode} {r.stderr!r}")
    # Ranks share the cores of the node.
    out = os.path.join(tmp, "ranks")
    r = run("mpirun", "-n", "2", bvp, write(tmp, block.replace("frames = 100000", "frames = 0")), "-o", out, "--quiet")
    need(
        r.returncode == 0 and summary(out)["threads"] == max(1,
                                                             len(os.sched_getaffinity(0)) // 2)
        and summary(out)["ranks"] == 2, f"threads of two ranks: {r.stderr}")
    # Interrupted while the cells are prepared: heard, and what is prepared is kept.
    write(
        tmp, MATERIAL + CELL.replace("layers = [3, 3, 3]", "layers = [14, 14, 14]").replace(
            "[preparation]", "[preparation]\ninertial_number = 1e-7"), "cell.toml")
    out = os.path.join(tmp, "slow")
    code, said, err = interrupted(tmp, "unit cells", [bvp, write(tmp, block), "-o", out], "unit cells", signal.SIGINT,
                                  20)
    need(
        code == 130 and "unit cells" in err and err.count("\n") == 1
        and sorted(os.listdir(out)) == [".grus", "preparation.h5"], f"interrupted unit cells: exit {code} {err!r}")
    write(tmp, MATERIAL + CELL, "cell.toml")
    # Increments that are cut are told, but not to who asked for quiet; the hint says more increments, not smaller ones.
    wild = block.replace("-0.02 mm", "-9 mm").replace("increments = 1", "increments = 1\nmax_cutbacks = 1")
    loud, quiet = (run(bvp, write(tmp, wild), "-o", os.path.join(tmp, f"wild{k}"), *more, timeout=300)
                   for k, more in enumerate(((), ("--quiet",))))
    need("cutback" in loud.stdout, f"a cutback is not told: {loud.stdout!r}")
    need(
        loud.returncode == quiet.returncode == 3 and "more solve.increments" in quiet.stderr and quiet.stdout == ""
        and quiet.stderr.count("\n") == 1, f"quiet: {quiet.returncode} {quiet.stdout!r} {quiet.stderr!r}")


def increments(tmp):
    """What no increment can solve, and options that PETSc does not know: one line before anything is prepared."""
    if not bvp:
        return
    body = ("[mesh]\nbox = { size = [1, 2], cells = [2, 4] }\ndimension = \"plane-strain\"\n[[region]]\n"
            "where = \"y>0\"\nmaterial = \"elastic\"\nyoungs_modulus = 1e9\npoissons_ratio = 0.2\n[[boundary]]\n"
            "where = \"y=max\"\ndisplacement = [\"free\", -1e-3]\n[[boundary]]\nwhere = \"x=min\"\npressure = 1e5\n"
            "history = \"ramp\"\n[[boundary]]\nwhere = \"x=max\"\npressure = 1e5\nhistory = \"ramp\"\n")
    newton = body + "[solve]\nkind = \"quasi-static\"\nincrements = 1\n"
    for arguments in ((), ("--check", )):
        refused(tmp, newton, "scene.toml: boundary: nothing stops the body from moving along x,", "[[boundary]]",
                program=bvp, arguments=arguments)
    held = newton + "[[boundary]]\nwhere = \"x=min and y=max\"\nname = \"pin\"\ndisplacement = [0, \"free\"]\n"
    free = body + "[solve]\nkind = \"explicit-quasi-static\"\n"
    for name, text in (("held", held), ("explicit", free)):
        r = run(bvp, write(tmp, text), "-o", os.path.join(tmp, name), "--quiet")
        need(r.returncode == 0 and r.stderr == "", f"{name}: exit {r.returncode} {r.stderr!r}")
    before = os.environ.get("PETSC_OPTIONS")
    os.environ["PETSC_OPTIONS"] = "-grus_pc_type nonsense"
    refused(tmp, held, "scene.toml: solve: PETSc refuses its options", '"-grus_pc_type nonsense"', "PC type nonsense",
            program=bvp)
    refused(tmp, held, "PC type nonsense", program=bvp, arguments=("--check", ))
    os.environ["PETSC_OPTIONS"] = "-grus_kps_type cg"
    r = run(bvp, write(tmp, held), "-o", os.path.join(tmp, "unused"))
    need(r.returncode == 0 and "PETSc has no use for its option -grus_kps_type cg" in r.stdout, f"unused: {r.stdout!r}")
    os.environ["PETSC_OPTIONS"] = "-grus_ksp_type cg"
    r = run(bvp, write(tmp, held), "-o", os.path.join(tmp, "used"))
    need(r.returncode == 0 and "PETSc" not in r.stdout + r.stderr, f"used: {r.stdout!r} {r.stderr!r}")
    del os.environ["PETSC_OPTIONS"]
    os.environ.update({} if before is None else {"PETSC_OPTIONS": before})
    # A run that has finished says so, whatever it has left.
    out = os.path.join(tmp, "held")
    r = run(bvp, write(tmp, held), "-o", out, "--resume")
    need(r.returncode == 2 and "the run has finished" in r.stderr and r.stderr.count("\n") == 1, f"done: {r.stderr!r}")
    out, often = os.path.join(tmp, "often"), ("--set", "output.checkpoint_interval=1e-9", "--set", "solve.increments=3")
    need(run(bvp, write(tmp, held), "-o", out, "--quiet", *often).returncode == 0, "a run with checkpoints")
    need(os.path.exists(os.path.join(out, "checkpoint.h5")), "no checkpoint is left of a run that wrote some")
    for after in ("", "checkpoint.h5"):
        if after:
            os.remove(os.path.join(out, after))
        r = run(bvp, write(tmp, held), "-o", out, "--resume", *often)
        need(r.returncode == (2 if after else 0) and "run has finished" in (r.stderr if after else r.stdout),
             f"done: {r.returncode} {r.stdout!r} {r.stderr!r}")


def forgetful(tmp):
    """A regularisation that forgets at once gives energy: the run ends, and says what to change."""
    if not bvp:
        return
    out = os.path.join(tmp, "forgetful")
    r = run(bvp, os.path.join(shipped, "biaxial_plane_strain.toml"), "-o", out, "--quiet", *(
        a for s in ("mesh.box.cells=[4,8]", "probe=", "output.frames=0", "regularisation.length='20 mm'",
                    "regularisation.memory=1e-5", "boundary.1.displacement=[0,'-4 mm']",
                    "rve.set=['packing.box=[0.03,0.03,0.03]','numerics.max_overlap=0.3','preparation.friction=0']")
        for a in ("--set", s)), timeout=300)
    need(r.returncode == 3 and "regularisation_J has fallen by" in r.stderr and r.stderr.count("\n") == 1
         and "a larger regularisation.memory" in r.stderr, f"forgetful: exit {r.returncode} {r.stderr!r}")
    need(float(history(out)[-1]["time_s"]) < 0.9, "forgetful: went on to its end")
    s = summary(out)
    need(s["status"] == 3 and any("regularisation_J" in note for note in s["notes"]), f"forgetful: {s.get('notes')}")


def gives_up(tmp):
    """With a length, RVEs give up where the band is, and nowhere else; the run goes on, and its energy closes."""
    if not bvp:
        return
    settings = ("mesh.box.cells=[4,8]", "solve.crossings=20", "probe=", "output.frames=81",
                "regularisation.length='6 mm'", "regularisation.memory=0.003", "boundary.1.displacement=[0,'-9 mm']",
                "rve.set=['packing.box=[0.028,0.028,0.028]','numerics.max_overlap=0.08','preparation.friction=0']")

    def told(policy):
        out = os.path.join(tmp, policy)
        return out, run(bvp, os.path.join(shipped, "biaxial_plane_strain.toml"), "-o", out, "--quiet",
                        *(a for s in (*settings, "rve.on_failure=" + policy) for a in ("--set", s)), timeout=300)

    ended, r = told("stop")
    point = re.search(r"RVE of point (\d+): overlap", r.stderr)
    need(r.returncode == 3 and point and 'rve.on_failure = "elastic"' in r.stderr, f"deeper than 8 %: {r.stderr!r}")
    sheared = shears(os.path.join(ended, "macro"))
    points = 4  # of an element
    need(point and sheared[int(point[1]) // points] > np.quantile(sheared, 0.75), f"{point} gave up beside {sheared}")
    went_on, r = told("elastic")
    rows, before = history(went_on), history(ended)
    need(r.returncode == 0 and r.stderr == "", f"went on: exit {r.returncode} {r.stderr!r}")
    same = len(before) - 2  # the last row of the run that ended is of where it ended
    column = "reaction_top_y_N"
    need([a[column] for a in rows[:same]] == [b[column] for b in before[:same]], "other rows before the first gave up")
    given = [float(a["rves_given_up"]) for a in rows]
    need(given[same - 1] == 0 and 0 < given[-1] < 64 and sorted(given) == given, f"{given} gave up")
    need(summary(went_on)["counts"]["rves_given_up"] == given[-1], "how many gave up")
    # Elastic points soften no more: the load rises again, where the band alone bore it before.
    least = min(abs(float(a[column])) for a, n in zip(rows[same:], given[same:]) if n <= 2)
    need(abs(float(rows[-1][column])) > 1.1 * least, f"the load stays at {least}")
    need(max(abs(float(a["energy_error"])) for a in rows[same:]) < 5e-3, "energy of a band that gave up")
    need(any(f"RVEs have given up at {given[-1]:.0f} points" in note for note in summary(went_on)["notes"]), "no note")


def comes_back(tmp):
    """What the regularisation holds comes back as the load is taken off, and is taken again: its largest fall is told,
    not the last; of a length that has no room."""
    if not bvp:
        return
    settings = ("mesh.box.cells=[4,8]", "solve.crossings=20", "probe=", "output.frames=0",
                "output.history_interval=2e-3", "regularisation.memory=0.1", "regularisation.length='26 mm'",
                "rve.set=['packing.box=[0.028,0.028,0.028]','numerics.max_overlap=0.3','preparation.friction=0']")

    def loaded(name, way):
        with open(os.path.join(shipped, "biaxial_plane_strain.toml")) as f:
            scene = f.read().replace('displacement = [0, "-10 mm"]', way)
        scene = scene.replace('"sphere_rve.toml"', f'"{os.path.join(shipped, "sphere_rve.toml")}"')
        out = os.path.join(tmp, name)
        r = run(bvp, write(tmp, scene, name + ".toml"), "-o", out, "--quiet", *(a for s in settings
                                                                                for a in ("--set", s)), timeout=300)
        need(r.returncode == 0, f"{name}: exit {r.returncode} {r.stderr!r}")
        return out, history(out)

    out, rows = loaded("back", 'displacement = [0, "-8 mm"]\nhistory = [[0, 0], [0.5, 1], [0.7, 0], [1, 0.9]]')
    held, work = ([float(a[k]) for a in rows] for k in ("regularisation_J", "macro_external_J"))
    falls = [max(held[:k + 1]) - x for k, x in enumerate(held)]
    most, end = (x / max(map(abs, work)) for x in (max(falls), falls[-1]))
    said = [re.search(r"regularisation_J has fallen by ([\d.]+) %", n) for n in summary(out)["notes"]]
    said = [float(m[1]) / 100 for m in said if m]
    need(most > 0.0055 and end < 0.6 * most, f"falls by {most}, at the end {end}: the test asks nothing")
    need(len(said) == 1 and 0.95 * most < said[0] < 1.6 * most, f"falls by {most}, told {said}")
    need(any("has no room in a body of 0.1 m" in n for n in summary(out)["notes"]), "no note of a long length")
    # A fall while little has been done yet is none of what has been done by the end.
    out, rows = loaded("early", 'displacement = [0, "-3 mm"]\nhistory = [[0, 0], [0.02, 0.1], [0.036, 0], [1, 1]]')
    held, work = ([float(a[k]) for a in rows] for k in ("regularisation_J", "macro_external_J"))
    early = max((max(held[:k + 1]) - x) / max(work[:k + 1]) for k, x in enumerate(held[:30]))
    need(early > 0.0055, f"an early fall of {early}: the test asks nothing")
    need(not any("regularisation_J" in n for n in summary(out)["notes"]), f"{summary(out)['notes']}")


def shears(folder):
    """Largest shear strain of each element of a plane mesh in the last frame: of the mean gradient of displacement."""
    with h5py.File(os.path.join(folder, sorted(f for f in os.listdir(folder) if f.endswith(".hdf"))[-1]), "r") as f:
        corners = f["VTKHDF/Connectivity"][:].reshape(-1, 4)
        at, moved = (f["VTKHDF/" + name][:][corners][:, :, :2].astype(float)
                     for name in ("Points", "PointData/displacement_m"))
    found = []
    for x, u in zip(at, moved):
        gradient = np.linalg.lstsq(np.column_stack([np.ones(4), x]), u, rcond=None)[0][1:]
        strain = (gradient + gradient.T) / 2
        found.append(np.ptp(np.linalg.eigvalsh(strain)))
    return np.array(found)


with tempfile.TemporaryDirectory() as tmp:
    macro(tmp)
    increments(tmp)
    forgetful(tmp)
    gives_up(tmp)
    comes_back(tmp)
print(f"attacks macro: {len(faults)} faults")
sys.exit(1 if faults else 0)
