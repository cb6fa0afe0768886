#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Makes the Debian packages of a build, unpacks them beside each other, and uses what is in them: check_packages.py BUILD full|dem"""
import glob
import os
import subprocess
import sys
import tempfile

build, kind = os.path.abspath(sys.argv[1]), sys.argv[2]
faults = []


def run(*command, cwd, **environment):
    r = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600, env={**os.environ, **environment})
    if r.returncode != 0:
        sys.exit(f"FAULT {' '.join(command)}: exit {r.returncode}\n{r.stdout[-2000:]}\n{r.stderr[-2000:]}")
    return r.stdout


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


with tempfile.TemporaryDirectory() as tmp:
    run("cpack", "-G", "DEB", "--config", os.path.join(build, "CPackConfig.cmake"), "-B", tmp, cwd=tmp)
    packages = {os.path.basename(p).split("_")[0]: p for p in glob.glob(os.path.join(tmp, "*.deb"))}
    need(set(packages) == {"grus", "libgrus-dev", "python3-grus"}, f"packages {sorted(packages)}")
    depends = {name: run("dpkg-deb", "-f", path, "Depends", cwd=tmp) for name, path in packages.items()}
    need("libhdf5" in depends["grus"] and "python3-numpy" in depends["grus"], f"grus depends on {depends['grus']}")
    need(("libdolfinx" in depends["grus"]) == (kind == "full"), f"grus depends on {depends['grus']}")
    need("grus (= " in depends["python3-grus"] and "python3-numpy" in depends["python3-grus"], f"python3-grus depends on {depends['python3-grus']}")
    need("libeigen3-dev" in depends["libgrus-dev"], f"libgrus-dev depends on {depends['libgrus-dev']}")
    files = {name: {line.split()[-1].lstrip(".") for line in run("dpkg-deb", "-c", path, cwd=tmp).splitlines()} for name, path in packages.items()}
    for name, mine in {"grus": ["/usr/bin/grus-rve", "/usr/bin/grus-study", "/usr/share/grus/scenes/sand_rve.toml"], "libgrus-dev": ["/usr/include/grus/rve.hpp", "/usr/lib/cmake/grus/grusConfig.cmake"],
                       "python3-grus": ["/usr/lib/python3/dist-packages/grus/__init__.py", "/usr/lib/python3/dist-packages/grus_precice.py"]}.items():
        for path in mine:
            need([n for n, all_of_it in files.items() if path in all_of_it] == [name], f"{path} is not in {name} alone")
    root = os.path.join(tmp, "root")
    for path in packages.values():
        run("dpkg-deb", "-x", path, root, cwd=tmp)
    scenes = os.path.join(root, "usr", "share", "grus", "scenes")
    run(os.path.join(root, "usr", "bin", "grus-rve"), os.path.join(scenes, "sand_box.toml"), "--set", "loading.final_strain=0.001", "-o", "out", "--quiet", cwd=tmp)
    run(os.path.join(root, "usr", "bin", "grus-report"), "out", cwd=tmp)
    said = run(sys.executable, "-c", f"import grus, numpy; print(grus.__file__, grus.Rve({scenes + '/sand_rve.toml'!r}).advance(numpy.eye(3))[0][2] < 0, len(grus.load('out')))", cwd=tmp,
               PYTHONPATH=os.path.join(root, "usr", "lib", "python3", "dist-packages"))
    need(said.startswith(root) and " True " in said, f"the package's grus says {said}")
print(f"packages: {len(faults)} faults")
sys.exit(1 if faults else 0)
