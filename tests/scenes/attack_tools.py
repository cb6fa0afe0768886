# SPDX-License-Identifier: LGPL-3.0-or-later
"""What attacks share: scenes, what is refused, what is interrupted."""
import os
import resource
import subprocess
import sys
import time

import scene_tools
from scene_tools import need, run, write

binaries = os.path.abspath(sys.argv[-1])
rve, bvp = (scene_tools.program(binaries, name) for name in ("grus-rve", "grus-bvp"))
study, calibrate, report, grus = (os.path.join(binaries, name)
                                  for name in ("grus-study", "grus-calibrate", "grus-report", "grus"))

MATERIAL = ("[material.sand]\ndensity = 2650\nyoungs_modulus = \"60 GPa\"\npoissons_ratio = 0.17\nfriction = 0.5\n"
            "restitution = 0.5\n")
BALL = MATERIAL + ("[[grain]]\nradius = \"1 mm\"\nposition = [0, 0, \"1.2 mm\"]\nvelocity = [0, 0, -1]\n[[wall]]\n"
                   "point = [0, 0, 0]\nnormal = [0, 0, 1]\nrigid = true\n")
FREE = "[loading]\nkind = \"free\"\nduration = \"2 ms\"\n"
UNIAXIAL = "[loading]\nkind = \"uniaxial-strain\"\nstrain_rate = 500.0\nfinal_strain = 0.02\n"


def box(kind="walls", fraction=0.5, side="3 mm", seed=1, loading=UNIAXIAL, more=""):
    return (
        MATERIAL +
        f"[packing]\nkind = \"random\"\nbox = [\"{side}\", \"{side}\", \"{side}\"]\n"
        f"radius = {{ distribution = \"uniform\", min = \"0.2 mm\", max = \"0.4 mm\" }}\n"
        f"solid_fraction = {fraction}\nseed = {seed}\n[boundary]\nkind = \"{kind}\"\n" + loading + more)


def refused(tmp, text, *words, program=None, arguments=(), code=2):
    """One line that says so, and nothing left behind."""
    out = os.path.join(tmp, "refused")
    r = run(program or rve, write(tmp, text), "-o", out, *arguments, timeout=60)
    need(r.returncode == code and r.stderr.count("\n") == 1 and all(w in r.stderr for w in words),
         f"{words}: exit {r.returncode}: {r.stderr[:300]!r}")
    need(not os.path.exists(out), f"{words}: created {out}")


def limited(what, amount):
    return lambda: resource.setrlimit(what, (amount, amount))


def interrupted(tmp, name, arguments, word, sent, deadline):
    """Starts, sends a signal half a second after a word has been said, or after that many seconds; (exit, outputs)."""
    said, errors = os.path.join(tmp, "said"), os.path.join(tmp, "errors")
    with open(said, "w") as out, open(errors, "w") as err:
        p = subprocess.Popen(arguments, stdout=out, stderr=err)
        begin = time.time()
        while p.poll() is None and time.time() - begin < 120:
            if word in open(said).read() if isinstance(word, str) else time.time() - begin > word:
                break
            time.sleep(0.05)
        time.sleep(0.5)
        need(p.poll() is None, f"{name}: ended before it could be interrupted")
        p.send_signal(sent)
        try:
            p.wait(timeout=deadline)
        except subprocess.TimeoutExpired:
            p.kill()
            p.wait()
            need(False, f"{name}: no end within {deadline} s")
    return p.returncode, open(said).read(), open(errors).read()
