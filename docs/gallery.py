#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures and times of the shipped scenes: gallery.py BUILD [SCENE...] [--seconds N]

Runs each scene that has no picture of its own on a page, on one core and for so many seconds at most (20), draws its
last frame into images/gallery/ and keeps in gallery.csv what it took, or how far it got. (cmake --build build --target
gallery) What cannot be drawn is told, and has no picture."""
import argparse
import csv
import glob
import json
import os
import re
import subprocess
import sys
import tempfile

docs = os.path.dirname(os.path.abspath(__file__))
scenes = os.path.normpath(os.path.join(docs, "..", "apps", "scenes"))
TABLE = os.path.join(docs, "gallery.csv")
# Pictures that pages have made of whole runs, and the page that tells what they took.
ON_PAGES = {"shpb_random": ("images/crushed.png", "benchmarks.md"),
            "brazilian_disc": ("images/brazilian_disc.png", "bonded.md"),
            "biaxial_plane_strain": ("problems/images/biaxial_field.png", "problems/biaxial_plane_strain.md"),
            "oedometer_block": ("problems/images/oedometer_block.png", "problems/oedometer_block.md"),
            "pile_tip": ("problems/images/pile_field.png", "problems/pile_tip.md"),
            "shpb_bars": ("problems/images/shpb_bars.png", "problems/shpb_bars.md"),
            "strip_footing": ("problems/images/footing_field.png", "problems/strip_footing.md"),
            "triaxial": ("problems/images/triaxial_field.png", "problems/triaxial.md"),
            "triaxial_block": ("problems/images/block_field.png", "problems/triaxial_block.md")}


def shipped():
    """Names of the scenes that are run by themselves; studies draw their own plots."""
    for path in sorted(glob.glob(f"{scenes}/**/*.toml", recursive=True)):
        name = os.path.relpath(path, scenes)[:-5]
        with open(path) as f:
            text = f.read()
        if not name.startswith("new/") and not re.search(r"^\[(study|calibrate)\]", text, re.M):
            yield name, "grus-bvp" if re.search(r"^\[mesh\]", text, re.M) else "grus-rve"


def picture(run, name, to):
    """Draws the last frame of a run; false where there is none."""
    from grus.figures import plt
    from grus.report import pictures
    drawn = pictures.grains(run, name)
    drawn = [drawn] if drawn else pictures.macro(run, name)
    if not drawn:
        return False
    figure, axis = plt.subplots(figsize=(5.2, 4))
    drawn[0](axis)
    axis.set_title("")
    os.makedirs(os.path.dirname(to), exist_ok=True)
    figure.savefig(to, dpi=80, bbox_inches="tight")
    plt.close(figure)
    return True


def made(build, name, program, seconds):
    """Row of the table: runs the scene and draws it."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "run")
        before = os.times()
        told = subprocess.run([os.path.join(build, "bin", program), os.path.join(scenes, name + ".toml"), "-o", out,
                               "--set", "output.frames=20", "--quiet", "--threads", "1", "--max-time", f"{seconds}s"],
                              capture_output=True, text=True)
        spent = sum(os.times()[2:4]) - sum(before[2:4])  # CPU seconds of what has ended
        if not os.path.exists(os.path.join(out, "summary.json")):
            print(f"{name}: no picture: {told.stderr.strip() or 'the run did not begin in that time'}")
            return {"scene": name, "cpu_s": "", "ending": "not begun", "picture": ""}
        with open(os.path.join(out, "summary.json")) as f:
            summary = json.load(f)
        path = f"images/gallery/{name.replace('/', '_')}.png"
        if not picture(out, name, os.path.join(docs, path)):
            print(f"{name}: no picture: no frame of it was written")
            path = ""
        with open(os.path.join(out, "history.csv"), newline="") as f:
            row = list(csv.DictReader(f))[-1]
        at = f"a load factor of {float(row['time_s']):.3g}"
        if program == "grus-rve":
            strain = float(row["axial_strain"])
            at = f"a strain of {strain:.3g}" if abs(strain) > 1e-6 else f"{float(row['time_s']):.3g} s"
        done = summary["status"] == 0
        return {"scene": name, "cpu_s": f"{spent:.2g}" if done else "",
                "ending": "finished" if done else at, "picture": path}


def keep(rows):
    with open(TABLE, "w", newline="") as f:
        table = csv.DictWriter(f, ["scene", "cpu_s", "ending", "picture"], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("scene", nargs="*")
    parser.add_argument("--seconds", type=int, default=20)
    asked = parser.parse_args()
    sys.path.insert(0, os.path.join(asked.build, "python"))
    rows = {}
    if os.path.exists(TABLE):
        with open(TABLE, newline="") as f:
            rows = {row["scene"]: row for row in csv.DictReader(f)}
    known = dict(shipped())
    for name, program in known.items():
        if name in ON_PAGES:
            rows[name] = {"scene": name, "cpu_s": "", "ending": ON_PAGES[name][1], "picture": ON_PAGES[name][0]}
        elif name in asked.scene or not asked.scene:
            rows[name] = made(asked.build, name, program, asked.seconds)
            print(rows[name], flush=True)
            keep(rows[k] for k in known if k in rows)
        keep(rows[name] for name in known if name in rows)


if __name__ == "__main__":
    main()
