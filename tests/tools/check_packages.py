#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Makes the Debian packages of a build, unpacks them beside each other, and uses what is in them: check_packages.py
BUILD full|dem"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

build, kind = os.path.abspath(sys.argv[1]), sys.argv[2]
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
# What lintian looks at in seconds; in libgrus-dev it takes the static libraries apart, so that package is asked here
# alone.
LINTED = ("grus", "python3-grus")
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


def check_conda():
    """The recipe of conda, which no test builds: this version, and all that CMake and the package ask for."""
    read = lambda *path: open(os.path.join(source, *path)).read()
    recipe = read("cmake", "conda", "meta.yaml")
    version = re.search(r"project\(grus VERSION ([0-9.]+)", read("CMakeLists.txt"))[1]
    need(f'set version = "{version}"' in recipe, f"the recipe of conda is not of version {version}")
    of_cmake = re.findall(r"find_package\((\w+)", read("CMakeLists.txt") + read("apps", "CMakeLists.txt"))
    asked = {*of_cmake} - {"Threads", "MPI", "DOLFINX", "Python"}
    part = lambda name: re.search(rf"^  {name}:\n((?:    .*\n)+)", recipe, re.M)[1]
    has = lambda names, name: re.search(rf"- {re.escape(name)}\b", names)
    lacking = [name for name in asked if not has(part("host"), {"Eigen3": "eigen"}.get(name, name.lower()))]
    python = re.findall(r'"(\w+)"', re.search(r"^dependencies = (.*)", read("pyproject.toml"), re.M)[1])
    lacking += [name for name in python if not has(part("run"), name)]
    need(not lacking and len(asked) > 5 and len(python) > 3, f"the recipe of conda lacks {lacking}")


check_conda()
with tempfile.TemporaryDirectory() as tmp:
    need('COMPRESSION_TYPE "xz"' in open(os.path.join(build, "CPackConfig.cmake")).read(),
         "compressed as not every Debian reads it")
    pack = ("cpack", "-G", "DEB", "--config", os.path.join(build, "CPackConfig.cmake"), "-B", tmp, "-D",
            "CPACK_DEBIAN_COMPRESSION_TYPE=gzip")  # faster
    nobody = {
        **os.environ, "DEBFULLNAME": "", "DEBEMAIL": "", "GIT_DIR": os.path.join(tmp, "no"),
        "GIT_CONFIG_GLOBAL": "/dev/null", "GIT_CONFIG_NOSYSTEM": "1"
    }
    r = subprocess.run(pack, cwd=tmp, capture_output=True, text=True, env=nobody)
    need(r.returncode != 0 and "DEBEMAIL=" in r.stderr and not glob.glob(os.path.join(tmp, "*.deb")),
         f"packages made by nobody: {r.returncode} {r.stderr!r}")
    run(*pack, cwd=tmp, DEBFULLNAME="", DEBEMAIL="Ada Tester <ada@lab.org>")
    packages = {os.path.basename(p).split("_")[0]: p for p in glob.glob(os.path.join(tmp, "*.deb"))}
    need(set(packages) == {"grus", "libgrus-dev", "python3-grus"}, f"packages {sorted(packages)}")
    depends = {name: run("dpkg-deb", "-f", path, "Depends", cwd=tmp) for name, path in packages.items()}
    need("libhdf5" in depends["grus"] and "python3-numpy" in depends["grus"], f"grus depends on {depends['grus']}")
    need(("libdolfinx" in depends["grus"]) == (kind == "full"), f"grus depends on {depends['grus']}")
    need("grus (= " in depends["python3-grus"] and "python3-numpy" in depends["python3-grus"],
         f"python3-grus depends on {depends['python3-grus']}")
    need("libeigen3-dev" in depends["libgrus-dev"], f"libgrus-dev depends on {depends['libgrus-dev']}")
    told = run("dpkg-deb", "-f", packages["grus"], "Recommends", cwd=tmp)
    need("python3-h5py" in told, f"grus recommends {told}")
    files = {
        name: {line.split()[-1].lstrip(".") for line in run("dpkg-deb", "-c", path, cwd=tmp).splitlines()}
        for name, path in packages.items()
    }
    site = "/usr/lib/python3/dist-packages"
    core = next((path for path in sorted(files["python3-grus"]) if re.fullmatch(rf"{site}/grus/_core\..*\.so", path)),
                "no compiled core")
    for name, mine in {
            "grus": [
                "/usr/bin/grus-rve", "/usr/bin/grus-study", "/usr/share/grus/scenes/sand_rve.toml",
                f"{site}/grus/__init__.py", f"{site}/grus/report/command.py", f"{site}/grus/watch/page.html",
                f"{site}/grus/files/plots.js", "/usr/share/zsh/vendor-completions/_grus",
                *(f"/usr/share/bash-completion/completions/{program}" for program in ("grus", "grus-rve"))
            ], "libgrus-dev": ["/usr/include/grus/rve.hpp", "/usr/lib/cmake/grus/grusConfig.cmake"],
            "python3-grus": [core]
    }.items():
        for path in mine:
            need([n for n, all_of_it in files.items() if path in all_of_it] == [name], f"{path} is not in {name} alone")
    programs = {"grus", *(f"grus-{name}" for name in ("rve", "study", "calibrate", "report"))}
    programs |= {"grus-bvp"} if kind == "full" else set()
    found = {path[9:] for path in files["grus"] if path.startswith("/usr/bin/") and path[9:]}
    need(found == programs, f"in /usr/bin: {sorted(found ^ programs)} too many or too few")
    for name, path in packages.items():
        told = run("dpkg-deb", "-f", path, "Maintainer", "Description", "Section", cwd=tmp)
        need("Maintainer: Ada Tester <ada@lab.org>\n" in told and "Section: " in told, f"{name}: {told}")
        need(len([line for line in told.splitlines() if line.startswith(" ")]) > 3, f"{name}: no description")
        need({f"/usr/share/doc/{name}/{text}" for text in ("copyright", "changelog.gz")} <= files[name],
             f"{name}: no copyright or changelog")
    if shutil.which("help2man"):
        pages = {f"/usr/share/man/man1/{program}.1.gz" for program in programs}
        need(pages <= files["grus"], f"no manual: {sorted(pages - files['grus'])}")
    if shutil.which("lintian"):
        r = subprocess.run(["lintian", "--allow-root", "--fail-on", "error", *(packages[name] for name in LINTED)],
                           capture_output=True, text=True, timeout=300)
        clean = not re.search("^[EW]: ", r.stdout, re.M)  # Debian 12 has no warning either
        need(r.returncode == 0 and (clean or "2.116" not in run("lintian", "--version", cwd=tmp)),
             f"lintian: {r.stdout}{r.stderr}")
    else:
        print("packages: without lintian, nobody has asked Debian's rules (Debian: apt-get install lintian)")
    root = os.path.join(tmp, "root")
    for path in packages.values():
        run("dpkg-deb", "-x", path, root, cwd=tmp)
    for folder, _, names in os.walk(root):
        for name in names:
            with open(os.path.join(folder, name), "rb") as f:
                need(source.encode() not in f.read(), f"{name} names {source}, where it was built")
    scenes = os.path.join(root, "usr", "share", "grus", "scenes")
    run(os.path.join(root, "usr", "bin", "grus-rve"), os.path.join(scenes, "sand_box.toml"), "--set",
        "loading.final_strain=0.001", "-o", "out", "--quiet", cwd=tmp)
    run(os.path.join(root, "usr", "bin", "grus"), "report", "out", cwd=tmp)
    with open(os.path.join(tmp, "study.toml"), "w") as f:
        f.write(
            f"[study]\nscene = {os.path.join(scenes, 'sand_box.toml')!r}\nset = {{ 'loading.final_strain' = 0.001 }}\n"
            "at = [0.001]\n[[case]]\nname = 'a'\n"
        )
    os.symlink(os.path.join(root, "usr", "bin", "grus-study"),
               os.path.join(tmp, "mine"))  # as people link programs into a folder of their own
    run(os.path.join(tmp, "mine"), "study.toml", "--quiet", cwd=tmp)
    said = run(
        sys.executable, "-c",
        f"import grus, numpy; print(grus.__file__, grus.Rve({scenes + '/sand_rve.toml'!r}).advance(numpy.eye(3))[0][2] "
        "< 0, len(grus.load('out')))",
        cwd=tmp, PYTHONPATH=os.path.join(root, "usr", "lib", "python3", "dist-packages"))
    need(said.startswith(root) and " True " in said, f"the package's grus says {said}")
print(f"packages: {len(faults)} faults")
sys.exit(1 if faults else 0)
