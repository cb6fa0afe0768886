#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-study on a small study with known answers: study.py BIN"""
import glob
import json
import math
import os
import random
import subprocess
import sys
import tempfile

binaries = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(binaries, "..", "python"))
from grus.errors import InputError  # noqa: E402
from grus.runs.runner import Runner  # noqa: E402
from grus.study import numbers, statistics  # noqa: E402
from grus.study.kinds import check, precision, sweep  # noqa: E402
from grus.study.reader import read_study  # noqa: E402

faults = []
scenes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "apps", "scenes")


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


def study(*arguments):
    return subprocess.run([os.path.join(binaries, "grus-study"), *arguments], capture_output=True, text=True,
                          timeout=280)


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
    for claim, verdict in (("twice the strength", "holds"), ("a false claim", "DOES NOT HOLD"),
                           ("the whole grain", "holds")):
        need(any(verdict in x and claim in x and x.startswith(verdict) for x in lines),
             f"{claim}: not '{verdict}' in\n{text}")
    # pi s / 6 over the square of the height: Hoek and Brown's force between platens. Between two tests the force grows
    # by no more than 2 %; a grain that swings between platens feels a little more than their mean.
    weak = json.load(open(os.path.join(out, "runs", "weak@10", "summary.json")))["results"]
    need(
        0.995 < weak["peak_before_breakage_Pa"] / (math.pi * 275e6 / 6) <= 1.02
        and weak["peak_before_breakage_Pa"] <= weak["peak_axial_stress_Pa"], f"strength of a grain {weak}")
    need("never broken" in text, "the unbreakable grain is not called so")
    need(os.path.getsize(os.path.join(out, "report.html")) > 20000, "report without plots")
    summary = os.path.join(out, "runs", "weak@10", "summary.json")
    before = os.stat(summary).st_mtime_ns
    r = study(path, "-o", out, "--strict", "--quiet")
    need(os.stat(summary).st_mtime_ns == before, "a finished run was repeated")
    need(r.returncode == 1, f"--strict with a false claim: exit {r.returncode}")
    # A kept run that is damaged is done again; the others stay.
    of = lambda name: os.path.join(out, "runs", "weak@10", name)
    whole = {name: open(of(name)).read() for name in ("summary.json", "history.csv")}
    told = open(os.path.join(out, "study.csv")).read()
    other = os.stat(os.path.join(out, "runs", "weak@12", "summary.json")).st_mtime_ns
    damages = [("summary.json", None)] + [("summary.json", t) for t in ("", "no JSON", "{}", "[1]", '{"status": 0}')]
    rows = whole["history.csv"]
    damages += [("history.csv", t) for t in (None, "", rows[:len(rows) // 2], rows[:rows.rindex("\n", 0, -1) + 1],
                                             rows.replace("axial_stress_Pa", "sigma"), rows[:rows.index("\n") + 1])]
    runner, cases = Runner(out, "numerics.fracture_every", binaries, {}), read_study(path).named
    for name, damage in damages:
        os.remove(of(name))
        if damage is not None:
            open(of(name), "w").write(damage)
        failure = runner.run(cases[0], 10)[2]
        good = not failure and os.path.exists(of(name)) and len(open(of(name)).read()) > 0.9 * len(whole[name])
        need(good and "sigma" not in open(of(name)).read(),
             f"{name} was {str(damage)[:40]!r} and is not done again: {failure}")
    outside, run = os.path.join(tmp, "outside"), os.path.join(out, "runs", "weak@10")
    os.rename(run, outside)
    os.symlink(outside, run)
    os.remove(of("summary.json"))
    failure = runner.run(cases[0], 10)[2] or ""
    need("is a link" in failure and not os.path.exists(os.path.join(outside, "summary.json")),
         f"a run that is a link: {failure}")
    os.remove(run)
    os.rename(outside, run)
    r = study(path, "-o", out, "--quiet")
    need(r.returncode == 0, f"a kept run without summary.json: exit {r.returncode}: {r.stderr}")
    need(other == os.stat(os.path.join(out, "runs", "weak@12", "summary.json")).st_mtime_ns, "a whole run was repeated")
    less = lambda text: [line.split(",")[:5] for line in text.splitlines()]
    need(less(open(os.path.join(out, "study.csv")).read()) == less(told), "what was done again differs")
    open(path, "w").write(TEXT.replace("0.06", "0.05"))
    study(path, "-o", out, "--quiet")
    need(os.stat(summary).st_mtime_ns != before, "a run whose settings changed was not repeated")
    for bad, expected in (("[study]\nscen = 1\n", "unknown key 'scen'"),
                          ("title = 'no cases'\n", "at least one [[case]]"), ("not toml", "s.toml"),
                          ("[study]\nscene='x.toml'\n[[case]]\nname='a'\n", "no such scene"),
                          (TEXT.replace('reference = "weak"', 'reference = "wek"'), "'wek'")):
        open(path, "w").write(bad)
        r = study(path, "-o", os.path.join(tmp, "bad"))
        need(
            r.returncode == 2 and expected in r.stderr and r.stderr.count("\n") == 1
            and not os.path.exists(os.path.join(tmp, "bad")), f"{expected}: exit {r.returncode}: {r.stderr!r}")

# Power law: exact points give the exponent with no error; scattered ones cover it.
slope, error = statistics.power_law([(x, 3 * x ** 8.25) for x in (1.4, 1.5, 1.6, 1.7)])
need(abs(slope - 8.25) < 1e-9 and error < 1e-9, f"power law {slope} +- {error}")
scattered = [(x, 3 * x**2 * math.exp(0.05 * (-1)**k)) for k, x in enumerate((1, 2, 3, 4, 5, 6))]
slope, error = statistics.power_law(scattered)
need(abs(slope - 2) < 3 * error and 0 < error < 0.1, f"scattered power law {slope} +- {error}")
need(abs(numbers.position({"axial_strain": [0, 0.1, 0.2], "y": [0, 1, 4]}, "y", 0.15) - 2.5) < 1e-12, "interpolation")
need(math.isnan(numbers.position({"axial_strain": [0, 0.1], "y": [0, 1]}, "y", 0.15)),
     "a strain that was not reached")


def made_up(value, cpu, energy=0.0):
    """A run that ended with this value, at this cost."""
    return {
        "columns": {"axial_strain": [0.0, 1.0], "y": [0.0, value]}, "summary": {
            "status": 0, "errors": {"worst_energy_error": energy}, "counts": {},
            "seconds": {"cpu": cpu, "loading_wall": cpu}
        }
    }


# A made-up scheme of order 2, y = 1 + 3 h^2 at a cost of 1 / h: the order, the front and the recommendations are known.
steps = [0.4, 0.2, 0.1, 0.05, 0.025]
entry = {"name": "made up", "quantity": "y", "at": 1.0, "vary": {"h": steps}, "reference": 1.0}
result = precision.judge(entry, [({"h": h}, [made_up(1 + 3 * h * h, 1 / h)]) for h in steps], None, ".")
need(abs(result["order"][0] - 2) < 1e-9 and result["order"][1] < 1e-9, f"order 2 reported as {result['order']}")
need(result["front"] == [0, 1, 2, 3, 4], f"front {result['front']}")
best = {t: r and r["settings"]["h"] for t, r in result["recommended"].items()}
need(best == {0.1: 0.1, 0.01: 0.05, 0.001: None}, f"recommended {best}")  # 3 h^2 = 48 %, 12 %, 3 %, 0.75 %, 0.19 %
need(precision.pareto([(1, 5), (2, 6), (3, 3), (3, 4), (5, 1), (6, 1)]) == [0, 2, 4], "Pareto front")
need(precision.pareto([(2, 1), (1, 1)]) == [1], "Pareto front of equals")
# Scatter hides the order of what lies below it: those points are left out.
noisy = [({"h": h}, [made_up(1 + 3 * h * h + s, 1 / h) for s in (-0.02, 0.0, 0.02)]) for h in steps]
result = precision.judge(entry, noisy, None, ".")
need(abs(result["order"][0] - 2) < 1e-9, f"order under scatter {result['order']}")
need(all(r["interval"] > 0.04 for r in result["rows"]), "intervals of three seeds")
need(result["recommended"][0.01] is None, "a recommendation that forgets the interval")  # 5 % of scatter
# Student's quantiles from tables, and the interval's coverage of the truth: 95 % within what 4,000 draws allow (3
# sigma).
for freedom, quantile in ((1, 12.7062), (2, 4.30265), (4, 2.77645), (9, 2.26216), (30, 2.04227)):
    need(
        abs(statistics.student(0.95, freedom) / quantile - 1) < 1e-5,
        f"t({freedom}) = {statistics.student(0.95, freedom)}")
draw = random.Random(7)
t4 = statistics.student(0.95, 4)
student = statistics.student
statistics.student = lambda c, f: t4 if f == 4 else student(c, f)  # 4,000 quadratures are slow
covered = 0
for _ in range(4000):
    m, half = statistics.interval([draw.gauss(3.0, 2.0) for _ in range(5)])
    covered += abs(m - 3.0) <= half
need(abs(covered / 4000 - 0.95) < 3 * math.sqrt(0.95 * 0.05 / 4000), f"95 % interval covers {covered / 40:.1f} %")
# Paired by seed: what seeds share drops out.
off, half = statistics.difference([11.0, 21.0, 31.0, 41.0, 51.0], [10.0, 20.0, 30.0, 40.0, 50.0], True)
need(abs(off - 1) < 1e-12 and half < 1e-12, f"paired difference {off} +- {half}")
need(statistics.difference([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], False)[1] > 1, "unpaired difference without an interval")
columns = {"x": [0, 1, 2], "y": [0, 4, 2]}
for how, expected in (("peak", 4), ("last", 2), ("area", 5), ("at", 3)):
    need(
        abs(numbers.measured(columns, {"quantity": "y", "over": "x", "measure": how, "at": 1.5}) - expected) < 1e-12,
        f"measure {how}")

with tempfile.TemporaryDirectory() as tmp:
    path, out = os.path.join(tmp, "p.toml"), os.path.join(tmp, "out")
    text = open(os.path.join(scenes, "studies", "elastic_collision.toml")).read().replace(
        '"two_spheres.toml"', f'"{os.path.abspath(scenes)}/studies/two_spheres.toml"')
    open(path, "w").write(text)
    r = study(path, "-o", out, "--quiet")
    lines = open(os.path.join(out, "study.txt")).read().splitlines() if r.returncode == 0 else [r.stderr]
    orders = [float(x.split(": ")[1].split()[0]) for x in lines if x.startswith("observed order")]
    need(len(orders) == 2 and 1.5 < orders[0] < 2.4, f"leapfrog's order in a collision: {orders} {lines[:1]}")
    need(len(open(os.path.join(out, "precision.csv")).read().splitlines()) == 15, "precision.csv: 14 rows")
    for bad, expected in ((text.replace('"g1_z_m"', '"no_such_column"'), "no_such_column"),
                          (text.replace('measure = "last"', 'measure = "best"'), "'best'"),
                          (text.replace("vary = {", "varies = {"), "unknown key 'varies'"),
                          (text.replace('[0.5, 0.25, 0.125', '0.5 #'), "")):
        open(path, "w").write(bad)
        r = study(path, "-o", os.path.join(tmp, "bad"), "--quiet")
        need(r.returncode == 2 and expected in r.stderr and r.stderr.count("\n") == 1,
             f"{expected}: exit {r.returncode}: {r.stderr!r}")
# A sweep: the strength of a grain goes with the key, whichever value is first; changes carry their sign.
SWEEP = TEXT[:TEXT.index("[[case]]")].replace("seeds = [10, 12]", "seeds = [10, 20]") + """
[[sweep]]
name = "strength"
key = "material.sand.fracture.hoek_brown.compressive_strength"
values = ["550 MPa", "275 MPa"]
quantity = "results.peak_axial_stress_Pa"
[[sweep]]
name = "damping"
key = "material.sand.damping"
values = [0.0, 0.4]
quantity = "axial_stress_Pa"
at = [0.002, 0.2]
log_x = false
"""
with tempfile.TemporaryDirectory() as tmp:
    path, out = os.path.join(tmp, "sweep.toml"), os.path.join(tmp, "out")
    open(path, "w").write(SWEEP)
    r = study(path, "-o", out, "--quiet")
    need(r.returncode == 0, f"sweep: exit {r.returncode}: {r.stderr}")
    rows = [line.split(",")
            for line in open(os.path.join(out, "sweep.csv")).read().splitlines()] if r.returncode == 0 else []
    need(len(rows) == 7 and rows[0][:4] == ["sweep", "key", "value", "position"], f"sweep.csv: {rows}")
    need(
        len(rows) == 7 and abs(float(rows[2][7]) + 0.5) < 0.03 and float(rows[1][7]) == 0,
        f"half the strength changes the peak by {rows[2][7]}")
    need(
        len(rows) == 7 and "not reached" in rows[6][10] and "not reached" not in rows[4][10],
        f"a strain of 0.2 in a run to 0.06: {rows[-1]}")
    need(
        len(rows) == 7 and f"{100 * float(rows[2][7]):+.2g} %" in open(os.path.join(out, "study.txt")).read(),
        "no signed change in study.txt")
    need(
        os.path.getsize(os.path.join(out, "plots", "sweep_0.png")) > 5000
        and os.path.getsize(os.path.join(out, "plots", "sweep_1.png")) > 5000, "sweep without plots")
    for bad, expected in ((SWEEP.replace("key = \"material.sand.damping\"", ""), "needs 'key'"),
                          (SWEEP.replace("at = [0.002, 0.2]", ""), "needs 'at'"),
                          (SWEEP.replace("[0.0, 0.4]", "[0.0]"), "sweep"),
                          (SWEEP.replace("sand.damping", "sand.dumping"), "dumping")):
        open(path, "w").write(bad)
        r = study(path, "-o", os.path.join(tmp, "bad"), "--quiet")
        need(r.returncode in (1, 2) and expected in r.stderr and r.stderr.count("\n") == 1,
             f"{expected}: exit {r.returncode}: {r.stderr!r}")
    # What is misspelt is told before anything runs, with the place and what may have been meant.
    for old, new, expected in (
            ("results.peak_axial", "results.peek_axial",
             "summary.json will have no key 'results.peek_axial_stress_Pa' (did you mean "
             "'results.peak_axial_stress_Pa'?)"),
            ('quantity = "axial_stress_Pa"', 'quantity = "axial_stres_Pa"',
             "history.csv will have no column 'axial_stres_Pa' (did you mean 'axial_stress_Pa'?)")):
        bad = SWEEP.replace(old, new)
        open(path, "w").write(bad)
        line = next(k for k, text in enumerate(bad.splitlines(), 1) if text.startswith("quantity") and new in text)
        r = study(path, "--check", "-o", os.path.join(tmp, "misspelt"))
        need(r.returncode == 2 and f"{path}:{line}: sweep.quantity: " in r.stderr and expected in r.stderr
             and r.stderr.count("\n") == 1, f"{new}: exit {r.returncode}: {r.stderr!r}")
        need(not os.path.exists(os.path.join(tmp, "misspelt")), f"{new}: something has run")
# Grains that did not break have no strength, but one that is larger than what they bore: counted, never an end nor a
# value.
STRENGTH = TEXT[:TEXT.index("[[table]]")].replace("at = [0.01]",
                                                  'at = [0.01]\nquantities = ["results.peak_before_breakage_Pa"]') + """
[[check]]
claim = "whole against weak"
greater = ["whole", "weak"]
quantity = "results.peak_before_breakage_Pa"
[[check]]
claim = "weak against whole"
greater = ["weak", "whole"]
quantity = "results.peak_before_breakage_Pa"
[[check]]
claim = "near"
cases = ["weak", "whole"]
quantity = "results.peak_before_breakage_Pa"
near = 1.44e8
tolerance = 1e9
[[sweep]]
name = "strength"
key = "material.sand.fracture.hoek_brown.compressive_strength"
values = ["275 MPa", "1 TPa"]
quantity = "results.peak_before_breakage_Pa"
"""
with tempfile.TemporaryDirectory() as tmp:
    path, out = os.path.join(tmp, "strength.toml"), os.path.join(tmp, "out")
    open(path, "w").write(STRENGTH)
    r = study(path, "-o", out, "--quiet")
    need(r.returncode == 0, f"strengths: exit {r.returncode}: {r.stderr}")
    if r.returncode == 0:
        read = lambda name: [line.split(",") for line in open(os.path.join(out, name)).read().splitlines()]
        bore = json.load(open(os.path.join(out, "runs", "whole@10", "summary.json")))["results"]["peak_axial_stress_Pa"]
        text, (head, *rows), (_, *swept) = open(os.path.join(out,
                                                             "study.txt")).read(), read("study.csv"), read("sweep.csv")
        weak, _, whole = [dict(zip(head, row)) for row in rows]
        mean, least, unbroken = [f"{k}_results.peak_before_breakage_Pa" for k in ("mean", "at_least", "not_broken")]
        need(0.995 < float(weak[mean]) / (math.pi * 275e6 / 6) <= 1.02 and weak[unbroken] == "0",
             f"grains that break: {weak}")
        need(whole[mean] == "" and whole[unbroken] == "2", f"grains that do not: {whole}")
        need(
            abs(float(whole[least]) / bore - 1) < 1e-9 and f"> {bore:.4g} (2 of 2 not broken)" in text,
            f"{bore} in {whole}\n{text}")
        claims = {
            claim: line for line in text.splitlines()
            for claim in ("whole against weak", "weak against whole", "  near ") if claim in line
        }
        verdicts = {claim.strip(): line.split("  ")[0] for claim, line in claims.items()}
        need(
            verdicts == {"whole against weak": "holds", "weak against whole": "DOES NOT HOLD", "near": "DOES NOT HOLD"},
            f"{verdicts} of {claims}")
        need("2 of 4 values are not there: 2 grains did not break" in claims["  near "], f"{claims['  near ']}")
        need(
            swept[1][4] == swept[1][7] == "" and "2 of 2 not broken: at least" in swept[1][10]
            and float(swept[0][4]) > 0, f"sweep.csv: {swept}")
# What is not known is not near: the last of the values is not reached.
run_to = lambda strain: {"columns": {"axial_strain": [0.0, strain], "y": [0.0, 10 * strain]}, "summary": {"status": 0}}
near = {"claim": "c", "case": "a", "quantity": "y", "at": [0.1], "near": 1.0, "tolerance": 0.01}
need(
    check.check_of(near, {"a": [run_to(0.1), run_to(0.2)]})[0]
    and not check.check_of(near, {"a": [run_to(0.1), run_to(0.05)]})[0],
    "a strain that was not reached counts as near")
# Seed by seed: what the seeds share drops out of a change, and not out of a mean.
rows = sweep.judge({"quantity": "y", "at": 1.0},
                   [(k, {s: made_up(10.0 * s + 3 * k, 1.0) for s in (1, 2, 3)}) for k in (1, 2)])
need(
    abs(rows[1]["change"] - 3 / 23) < 1e-12 and rows[1]["change_interval"] < 1e-12 and rows[1]["interval"] > 20,
    f"changes seed by seed: {rows[1]}")
# A seed that is a list, of changes of a unit cell, joins those that a setting makes; any other takes its place.
runner = Runner(".", "rve.set", "bin", {})
case = {"program": "grus-bvp", "scene": "x.toml", "set": {"rve.set": ["numerics.safety=0.5"]}}
need(
    runner.command(case, ["packing.seed=2"])[-1] == 'rve.set=["numerics.safety=0.5", "packing.seed=2"]',
    f"seeds that are lists: {runner.command(case, ['packing.seed=2'])}")
need(
    runner.command(dict(case, set={"rve.set": 1}), 2)[-1] == "rve.set=2"
    and case["set"]["rve.set"] == ["numerics.safety=0.5"], "seeds that are numbers")
for path in glob.glob(os.path.join(scenes, "*", "*.toml")):
    if "\n[study]" in open(path).read():
        try:
            read_study(path)
        except InputError as e:
            need(False, f"a shipped study is refused: {e}")
print(f"study: {len(faults)} faults")
sys.exit(1 if faults else 0)
