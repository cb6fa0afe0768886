# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that are none, too large or too small; files that end too soon; places that cannot be written."""
import os

from bench import Run, case, collision, free, material, sphere


@case("nan, inf, 0, negative and text where a positive number belongs (radius, density, modulus, position, time)",
      "each refused in one line that names its key; nothing created")
def no_numbers(tmp):
    count = 0
    bad = []
    for key, words in (("grain.0.radius", "radius"), ("material.m.density", "density"),
                       ("material.m.youngs_modulus", "youngs_modulus"), ("loading.duration", "duration")):
        for value in ("nan", "inf", "0", "-1", "'none'"):
            r = Run(tmp, collision(), f"{key}={value}")
            count += 1
            if not r.refused(words):
                bad.append(f"{key}={value}: exit {r.exit} {r.error[:60]}")
    r = Run(tmp, collision(), "grain.0.position=[0,0,nan]")
    if not r.refused("position"):
        bad.append("position nan")
    return f"{count + 1 - len(bad)} of {count + 1} refused" + ("; " + "; ".join(bad) if bad else ""), not bad


@case("subnormal and huge numbers: radius 1e-310 m, modulus 1e300 Pa, density 1e-300, speed 1e200 m/s",
      "refused in one line, but for a far neighbour and a moment: free flight to round-off")
def huge_numbers(tmp):
    found, good = [], True
    for what, ending in (("grain.0.radius=1e-310", 2), ("grain.0.radius=1e150", 2),
                         ("material.m.youngs_modulus=1e300", 2), ("material.m.density=1e-300", 2),
                         ("material.m.density=1e300", 2), ("grain.0.velocity=[0,0,1e200]", 2),
                         ("grain.1.position=[0,0,1e300]", 0), ("loading.duration=1e-320", 0)):
        r = Run(tmp, collision(), what, timeout=20)
        flown = lambda: abs(r.last("g0_z_m") - r.columns["g0_z_m"][0] - r.last("time_s") * r.last("g0_vz_m_s")
                            ) < 1e-9 * 0.01 and r.last("g0_vz_m_s") == r.columns["g0_vz_m_s"][0]
        ok = r.refused() if ending == 2 else r.exit == 0 and r.finite and flown()
        found.append(f"{what.split('.')[-1]}: {r.exit if ok else r.exit} {'' if ok else r.error[:60]}".strip())
        good = good and ok
    return "; ".join(found), good


@case("a result folder that cannot be made", "one line that says why, exit 1")
def unwritable(tmp):
    blocked = os.path.join(tmp, "blocked")
    open(blocked, "w").write("a file")
    import subprocess

    import bench
    scene = os.path.join(tmp, "s.toml")
    open(scene, "w").write(collision())
    r = subprocess.run([os.path.join(bench.binaries, "grus-rve"), scene, "-o",
                        os.path.join(blocked, "out"), "--quiet"], capture_output=True, text=True)
    return (f"exit {r.returncode}: {r.stderr.strip().split('/out: ')[-1]}", r.returncode == 1
            and r.stderr.count("\n") == 1 and "cannot create the folder" in r.stderr)


@case("a scene cut short at every tenth of its length", "each refused in one line, nothing created")
def cut_short(tmp):
    text = collision()
    codes = []
    for k in range(1, 10):
        r = Run(tmp, text[: len(text) * k // 10] + "\n")
        codes.append(2 if r.refused() else f"{r.exit} {r.error[:50]}")
    return " ".join(map(str, codes)), all(c == 2 for c in codes)


@case("no grain at all; one grain and no wall", "refused in one line; a finite result of free flight")
def nearly_nothing(tmp):
    none = Run(tmp, material() + free(1e-3))
    one = Run(tmp, material() + sphere(0.01, (0, 0, 0), (1, 0, 0)) + free(1e-3))
    return (f"exit {none.exit}; x = {one.last('g0_x_m') if one.exit == 0 else one.error[-60:]}", none.refused("grain")
            and one.exit == 0 and abs(one.last("g0_x_m") - 1e-3) < 1e-9)
