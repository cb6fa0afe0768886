# SPDX-License-Identifier: LGPL-3.0-or-later
"""The words of the command grus: what each does, what it is given, its options. Help and completion are made of
them."""
from typing import NamedTuple


class Word(NamedTuple):
    """A subcommand. `given`: its argument, in capitals what it is; `options`: each with what it wants ("" nothing); of
    a `program`: one of those that it is another name for."""
    about: str
    given: str
    options: dict[str, str]
    program: str = ""


ANY = {"--help": ""}
RUN = {"-o": "DIR", "--threads": "N", "--set": "KEY=VALUE", "--check": "", "--columns": "", "--resume": "",
       "--quiet": "", "--force": "", "--max-time": "DURATION", "--log": "FILE", **ANY}
MANY = {"-o": "DIR", "--threads": "N", "--check": "", "--quiet": "", "--max-time": "DURATION", "--log": "FILE", **ANY}

WORDS = {
    "new": Word("write a commented scene to begin with", "KIND [SCENE.toml]", ANY),
    "keys": Word("tell every key of a scene: unit, range, default, example", "[TEXT]", {"--macro": "", **ANY}),
    "check": Word("say what a scene, a study or a calibration would do and cost; nothing is written", "FILE.toml",
                  {"--set": "KEY=VALUE", "--threads": "N", **ANY}),
    "run": Word("run a scene: by grus-rve, or by grus-bvp where it has a [mesh]", "SCENE.toml",
                {**RUN, "--ranks": "N"}),
    "watch": Word("follow a run or a study while it runs, in a browser of this machine", "DIR...",
                  {"--port": "N", "--stay": "", "--open": "", **ANY}),
    "report": Word("draw results: report.html with plots, tables and pictures", "DIR...",
                   {"-o": "FILE", "--force": "", **ANY}, "report"),
    "export": Word("write results as other programs read them: .vtu .stl .obj .txt .csv .npz .mat", "DIR",
                   {"-o": "FILE", "--what": "KIND", "--frame": "N", "--columns": "NAMES", "--force": "",
                    **ANY}),
    "study": Word("run a scene over many settings: error against run time, sweeps, claims", "STUDY.toml",
                  {**MANY, "--strict": ""}, "study"),
    "calibrate": Word("find keys of a scene from measured data", "CALIBRATION.toml", {**MANY, "--resume": ""},
                      "calibrate"),
    "completion": Word("print what a shell needs to complete these words", "SHELL", ANY),
}
KINDS = {
    "oedometer": "sand in a periodic cell, compressed along one axis", "triaxial": "sheared under a lateral stress",
    "shpb": "a sample between walls at 500/s, as in a split Hopkinson bar",
    "stages": "a sand in stages: compressed, unloaded, loaded again, sheared",
    "single-grain": "one grain between platens", "bonded": "rock of bonded Voronoi cells",
    "ucs": "a cylinder of rock between platens", "brazilian": "a disc of rock, split across",
    "bending": "a beam of rock on rollers", "triaxial-rock": "a block of rock under pressure on its sides"
}
# Of these grus-bvp writes two files: with the scene of the RVEs.
PROBLEMS = {
    "biaxial": "FE x DEM: sand in plane strain between platens", "footing": "FE x DEM: a strip footing on sand",
    "pile": "FE x DEM: a pile that is pushed into sand",
    "block-dolfinx": "a program of DOLFINx with grains as its material (Python)"
}
SHELLS = ("bash", "zsh")
FRAMES = ("history", "grains", "macro", "contacts")
# Of the programs that run scenes: options that take the word after them.
VALUED = {o for o, wants in {**RUN, "--ranks": "N"}.items() if wants}
STUDIES = ("study", "case", "precision", "sweep", "table", "fit", "check", "plot")  # tables that a study may have


def help_text(version: str) -> str:
    """What grus --help prints."""
    width = max(len(f"{name} {word.given}") for name, word in WORDS.items())
    lines = [f"  {name + ' ' + word.given:<{width}}  {word.about}" for name, word in WORDS.items()]
    return f"""Usage: grus COMMAND ...

Grus {version}: grains that break, alone and at the points of finite elements. Commands:

{chr(10).join(lines)}

A first hour:
  grus new oedometer                    writes oedometer.toml; each key has its comment
  grus check oedometer.toml             grains, time step, memory, run time
  grus run oedometer.toml -o results    until it is done; Ctrl-C leaves a checkpoint, --resume goes on
  grus watch results                    in a second terminal: curves, energy, how long it will take
  grus report results                   results/report.html

Options of one command: grus COMMAND --help. A key or two changed: --set packing.seed=7.
The programs have names of their own: grus-rve, grus-bvp, grus-report, grus-study, grus-calibrate.
Exit status: 0 finished, 2 refused, 3 unstable or not converged, 75 out of time, 130 interrupted, 1 other failure.
"""
