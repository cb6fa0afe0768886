#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Installs a build, and builds and runs a client of it from an empty folder: check_install.py BUILD full|dem"""
import glob
import os
import re
import subprocess
import sys
import tempfile

build, kind = os.path.abspath(sys.argv[1]), sys.argv[2]

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
page = open(os.path.join(source, "docs", "library.md")).read()
PUBLIC = ["grus/rve.hpp", "grus/rves.hpp", "grus/sample.hpp", "grus/scene.hpp"
          ] + [f"dem/rve/{name}.hpp" for name in ("model", "state", "rve", "measure", "step")]
CMAKE, CLIENT = (re.search(rf"```{kind_of_block}\n(.*?)```", page, re.S).group(1) for kind_of_block in ("cmake", "cpp"))
SAID = re.search(r"says `(.*?)`", page).group(1)
SAMPLE, SAID_OF_SAMPLE = re.search(r"```cpp\n(#include <grus/sample.hpp>.*?)```\n\nIt says `(.*?)`", page,
                                   re.S).groups()
COMMANDS = ["grus", "grus-study", "grus-calibrate", "grus-report"]
WITHOUT_CORE = "RVEs in Python need Debian's python3-grus, or a build where python3-dev and pybind11-dev are there"
# Two spheres pushed together by 1 % of a radius: Hertz's force is the closed form.
DEM = """#include <cstdio>
#include "dem/rve/step.hpp"
using namespace grus::dem;
int main() {
  Model model;
  Material m;
  m.youngs_modulus = 60e9, m.poissons_ratio = 0.17;
  model.materials = {m};
  make_pair_laws(model);
  State s;
  for (int i = 0; i < 2; ++i)
    set_grain(s.grains, i,
              {.shape = PolyEllipsoid::sphere(1e-3), .position = Vec3(i * 1.99e-3, 0, 0), .density = 2650});
  Team team(2);
  prepare(model, s, team);
  std::printf("%.6g\\n", s.grains.force[1].x());
}
"""
# A scene file from the outside: two spheres a little apart.
SCENE = """#include <cstdio>
#include "grus/scene.hpp"
int main() {
  std::FILE* f = std::fopen("two.toml", "w");
  std::fputs("[material.sand]\\ndensity = 2650\\nyoungs_modulus = \\"60 GPa\\"\\npoissons_ratio = 0.17\\n"
             "[boundary]\\nkind = \\"open\\"\\n"
             "[[grain]]\\nradius = \\"1 mm\\"\\nposition = [0, 0, 0]\\n"
             "[[grain]]\\nradius = \\"1 mm\\"\\nposition = [0.0019, 0, 0]\\n"
             "[loading]\\nkind = \\"free\\"\\nduration = 1e-6\\n", f);
  std::fclose(f);
  grus::app::RveScene scene = grus::app::read_rve_scene("two.toml", {"material.sand.youngs_modulus=30e9"});
  grus::dem::Team team(1);
  const grus::dem::State s = grus::app::prepare_sample(scene, team);
  std::printf("%zu %.6g\\n", s.grains.size(), scene.model.materials[0].youngs_modulus);
}
"""
MACRO = """#include <cstdio>
#include "coupling/rve_farm.hpp"
#include "fem/session.hpp"
#include "fem/statics.hpp"
using namespace grus;
int main() {
  const fem::Session session;
  fem::BoundaryCondition low, high;
  low.name = "low", low.where = [](const fem::Point& x) { return x[2] < 1e-9; }, low.displacement = {0.0, 0.0, 0.0};
  high.name = "high", high.where = [](const fem::Point& x) { return x[2] > 1 - 1e-9; };
  high.displacement = {0.0, 0.0, -1e-3};
  fem::Problem problem(MPI_COMM_WORLD, fem::BoxMesh{}, {}, {low, high});
  fem::Material m = fem::elastic_material(problem.owned_points(), 1e9, 0);
  fem::solve_statics(problem, m, {.increments = 1}, [](const fem::IncrementReport&) { return true; });
  std::printf("%.6g %zu\\n", problem.reaction(1)[2], coupling::balance({1, 2}, 2).size());
}
"""


def run(*command, cwd, **environment):
    r = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600, env={**os.environ, **environment})
    if r.returncode != 0:
        sys.exit(f"FAULT {' '.join(command)}: exit {r.returncode}\n{r.stdout[-3000:]}\n{r.stderr[-3000:]}")
    return r.stdout


def python_package(tmp):
    """It is installed where Python looks, be that another folder for each prefix; else the line told is what Python
    needs. The commands find it in each, and need no compiled core: without it cells alone are lacking."""
    python = "/usr/bin/python3"
    looks = run(python, "-c", "import sys; print('\\n'.join(p for p in sys.path if p))", cwd=tmp).split()
    for prefix in ("/usr/local", "/usr", os.path.join(tmp, "elsewhere")):
        stage = os.path.join(tmp, "stage" + prefix.replace("/", "_"))
        told = run("cmake", "--install", build, "--prefix", prefix, "--component", "Unspecified", cwd=tmp,
                   DESTDIR=stage)
        line = re.search(r"export PYTHONPATH=(\S+)", told)
        if (line is not None) != prefix.startswith(tmp):
            sys.exit(f"FAULT --prefix {prefix}: {told}")
        path = os.pathsep.join(stage + p for p in (line.groups() if line else looks))
        nowhere = os.path.join(tmp, "nowhere")
        for program in COMMANDS:
            said = run(stage + os.path.join(prefix, "bin", program), "--version", cwd=tmp, PYTHONPATH=nowhere)
            if not re.fullmatch(rf"{program} [0-9.]+\n", said):
                sys.exit(f"FAULT --prefix {prefix}: {program} --version says {said!r}")
        found = run(python, "-c", "import grus; grus.load, grus.run; print(grus.__file__)", cwd=tmp, PYTHONPATH=path)
        if not found.startswith(stage + prefix + "/"):
            sys.exit(f"FAULT --prefix {prefix}: Python finds grus at {found}")
        r = subprocess.run([python, "-c", "import grus; grus.Rve"], cwd=tmp, capture_output=True, text=True,
                           env={**os.environ, "PYTHONPATH": path})
        if r.returncode != 1 or not r.stderr.endswith("No module named 'grus._core': " + WITHOUT_CORE + "\n"):
            sys.exit(f"FAULT --prefix {prefix}: cells without a compiled core: {r.stderr}")
        if glob.glob(os.path.join(build, "python", "grus", "_core.*.so")):
            run("cmake", "--install", build, "--prefix", prefix, "--component", "python", cwd=tmp, DESTDIR=stage)
            run(python, "-c", "import grus, grus.precice; grus.Rve, grus.precice.MicroSimulation", cwd=tmp,
                PYTHONPATH=path)


def scenes_have_their_meshes(installed):
    """Each mesh that an installed scene names is where the scene says, and so is each scene of the sources."""
    scenes = os.path.join(installed, "share", "grus", "scenes")
    names = lambda folder: {os.path.relpath(p, folder) for p in glob.glob(f"{folder}/**/*.toml", recursive=True)}
    if names(scenes) != names(os.path.join(source, "apps", "scenes")):
        sys.exit(f"FAULT scenes: {names(scenes) ^ names(os.path.join(source, 'apps', 'scenes'))}")
    meshes = [(path, name) for path in glob.glob(f"{scenes}/**/*.toml", recursive=True)
              for name in re.findall(r'^file = "(.*\.msh)"', open(path).read(), re.M)]
    missing = [pair for pair in meshes if not os.path.isfile(os.path.join(os.path.dirname(pair[0]), pair[1]))]
    if missing or len(meshes) < 2 or not os.path.isfile(os.path.join(scenes, "..", "meshes", "pile.msh")):
        sys.exit(f"FAULT meshes of installed scenes: {missing or meshes}")


def built(installed, folder, cmake):
    open(os.path.join(folder, "CMakeLists.txt"), "w").write(cmake)
    run("cmake", "-S", ".", "-B", "b", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={installed}", cwd=folder)
    run("cmake", "--build", "b", cwd=folder)


with tempfile.TemporaryDirectory() as tmp:
    installed = os.path.join(tmp, "installed")
    run("cmake", "--install", build, "--prefix", installed, cwd=tmp)
    scenes_have_their_meshes(installed)
    HERTZ = 4 / 3 * 60e9 / (2 * (1 - 0.17 ** 2)) * (0.5e-3) ** 0.5 * (0.01e-3) ** 1.5
    clients = [("grus::grus", CLIENT, lambda out: out == SAID + "\n"),
               ("grus::grus", DEM, lambda out: abs(float(out) / HERTZ - 1) < 1e-5),
               ("grus::grus", SCENE, lambda out: out.split() == ["2", "3e+10"]),
               ("grus::grus", SAMPLE, lambda out: out == SAID_OF_SAMPLE + "\n")]
    if kind == "full":
        clients.append(("grus::coupling", MACRO,
                        lambda out: abs(float(out.split()[0]) / -1e6 - 1) < 2e-3 and out.split()[1] == "2"))
    # The page's client by the page's text; the others, and every public header in a file of its own, in one project.
    page_client, rest = os.path.join(tmp, "page"), os.path.join(tmp, "rest")
    for folder in (page_client, rest):
        os.mkdir(folder)
    open(os.path.join(page_client, "main.cpp"), "w").write(CLIENT)
    built(installed, page_client, CMAKE)
    cmake = CMAKE[:CMAKE.index("add_executable")]
    for k, (target, text, _) in enumerate(clients[1:], 1):
        open(os.path.join(rest, f"main{k}.cpp"), "w").write(text)
        cmake += f"add_executable(client{k} main{k}.cpp)\ntarget_link_libraries(client{k} PRIVATE {target})\n"
    for number, header in enumerate(PUBLIC):
        open(os.path.join(rest, f"h{number}.cpp"), "w").write(f"#include <{header}>\n")
    cmake += (f"add_library(alone OBJECT {' '.join(f'h{k}.cpp' for k in range(len(PUBLIC)))})\n"
              "target_compile_options(alone PRIVATE -fsyntax-only)\ntarget_link_libraries(alone PRIVATE grus::grus)\n")
    built(installed, rest, cmake)
    for k, (target, _, right) in enumerate(clients):
        client = os.path.join(rest, "b", f"client{k}") if k else os.path.join(page_client, "b", "client")
        out = run(client, os.path.join(source, "apps", "scenes", "sand_rve.toml"), cwd=tmp)
        if not right(out):
            sys.exit(f"FAULT client of {target} says {out!r}")
        needs = [name for name in ("libmpi", "libpetsc", "libdolfinx") if name in run("ldd", client, cwd=tmp)]
        parallel = "HDF5_PREFER_PARALLEL ON" in open(os.path.join(build, "grusConfig.cmake")).read()
        if kind == "dem" and needs and not (parallel and needs == ["libmpi"]):
            sys.exit(f"FAULT a client of the DEM alone needs {needs}")
    for program in ["grus-rve", *COMMANDS] + (["grus-bvp"] if kind == "full" else []):
        run(os.path.join(installed, "bin", program), "--version", cwd=tmp)
    python_package(tmp)
print(f"install: {len(clients)} clients, 0 faults")
