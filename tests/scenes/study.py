#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-study on a small study with known answers: study.py BIN"""
import math
import os
import subprocess
import sys
import tempfile

binaries = os.path.abspath(sys.argv[1])
sys.path.insert(0, binaries)
import grus_study_report as report  # noqa: E402

faults = []
scenes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "apps", "scenes")


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


def study(*arguments):
    return subprocess.run([os.path.join(binaries, "grus-study"), *arguments], capture_output=True, text=True, timeout=280)


# The strength of a grain doubles with compressive_strength: F = 2 pi R^2 s / 3, the peak before anything breaks.
TEXT = f"""
[study]
scene = "{os.path.join(os.path.abspath(scenes), 'single_grain.toml')}"
seeds = [10, 12]
seed_key = "numerics.fracture_every"   # nothing is drawn for a listed grain: any key can take the place of a seed
at = [0.01]
set = {{ "output.frames" = 0, "loading.final_strain" = 0.06, "loading.strain_rate" = 1000.0 }}
[[case]]
name = "weak"
[[case]]
name = "strong"
set = {{ "material.sand.fracture.hoek_brown.compressive_strength" = "550 MPa" }}
[[case]]
name = "whole"
set = {{ "material.sand.fracture" = "" }}
[[table]]
name = "t"
reference = "weak"
cases = ["weak", "strong", "whole"]
[[plot]]
name = "p"
y = "axial_stress_Pa"
cases = ["weak", "strong"]
[[check]]
claim = "twice the strength, twice the peak"
greater = ["strong", "weak"]
quantity = "results.peak_axial_stress_Pa"
factor = 1.5
[[check]]
claim = "a false claim"
greater = ["weak", "strong"]
quantity = "results.peak_axial_stress_Pa"
[[check]]
claim = "the whole grain does not break"
case = "whole"
quantity = "counts.breakages"
below = 0
"""

with tempfile.TemporaryDirectory() as tmp:
    path, out = os.path.join(tmp, "s.toml"), os.path.join(tmp, "out")
    open(path, "w").write(TEXT)
    r = study(path, "--check")
    need(r.returncode == 0 and "6 runs" in r.stdout and not os.path.exists(out), f"--check: {r.stdout} {r.stderr}")
    r = study(path, "-o", out)
    need(r.returncode == 0, f"exit {r.returncode}: {r.stderr}")
    text = open(os.path.join(out, "study.txt")).read()
    lines = text.splitlines()
    for claim, verdict in (("twice the strength", "holds"), ("a false claim", "DOES NOT HOLD"), ("the whole grain", "holds")):
        need(any(verdict in x and claim in x and x.startswith(verdict) for x in lines), f"{claim}: not '{verdict}' in\n{text}")
    need("never broken" in text, "the unbreakable grain is not called so")
    need(os.path.getsize(os.path.join(out, "report.html")) > 20000, "report without plots")
    summary = os.path.join(out, "runs", "weak_s10", "summary.json")
    before = os.stat(summary).st_mtime_ns
    r = study(path, "-o", out, "--strict", "--quiet")
    need(os.stat(summary).st_mtime_ns == before, "a finished run was repeated")
    need(r.returncode == 1, f"--strict with a false claim: exit {r.returncode}")
    open(path, "w").write(TEXT.replace("0.06", "0.05"))
    study(path, "-o", out, "--quiet")
    need(os.stat(summary).st_mtime_ns != before, "a run whose settings changed was not repeated")
    for bad, expected in (("[study]\nscen = 1\n", "unknown key 'scen'"), ("title = 'no cases'\n", "at least one [[case]]"), ("not toml", "s.toml"),
                          ("[study]\nscene='x.toml'\n[[case]]\nname='a'\n", "no such scene"), (TEXT.replace('reference = "weak"', 'reference = "wek"'), "'wek'")):
        open(path, "w").write(bad)
        r = study(path, "-o", os.path.join(tmp, "bad"))
        need(r.returncode == 2 and expected in r.stderr and r.stderr.count("\n") == 1 and not os.path.exists(os.path.join(tmp, "bad")), f"{expected}: exit {r.returncode}: {r.stderr!r}")

# Power law: exact points give the exponent with no error; scattered ones cover it.
slope, error = report.power_law([(x, 3 * x ** 8.25) for x in (1.4, 1.5, 1.6, 1.7)])
need(abs(slope - 8.25) < 1e-9 and error < 1e-9, f"power law {slope} +- {error}")
slope, error = report.power_law([(x, 3 * x ** 2 * math.exp(0.05 * (-1) ** k)) for k, x in enumerate((1, 2, 3, 4, 5, 6))])
need(abs(slope - 2) < 3 * error and 0 < error < 0.1, f"scattered power law {slope} +- {error}")
need(abs(report.at({"axial_strain": [0, 0.1, 0.2], "y": [0, 1, 4]}, "y", 0.15) - 2.5) < 1e-12, "interpolation")
need(math.isnan(report.at({"axial_strain": [0, 0.1], "y": [0, 1]}, "y", 0.15)), "a strain that was not reached")
print(f"study: {len(faults)} faults")
sys.exit(1 if faults else 0)
