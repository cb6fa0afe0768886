# SPDX-License-Identifier: LGPL-3.0-or-later
"""What pip asks of pyproject.toml (PEP 517), by CMake and nothing else: the package grus with its compiled core and the
programs that run scenes, as a wheel. `--config-settings build-dir=build` takes a build that is there, with all that it
has; without it the DEM is built in a folder of its own."""
import base64
import hashlib
import io
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAMS = ("grus-rve", "grus-bvp")  # all others are of Python: pip makes them
SHIPPED = ("apps", "cmake", "coupling", "dem", "docs", "fem", "meshes", "tests", "CMakeLists.txt", "CMakePresets.json",
           "pyproject.toml", "bootstrap", "README.md", "CHANGELOG.md", "LICENSE", "COPYING.GPL-3", "CITATION.cff")


def version():
    with open(os.path.join(source, "CMakeLists.txt")) as f:
        return re.search(r"project\(grus VERSION ([0-9.]+)", f.read())[1]


def project():
    with open(os.path.join(source, "pyproject.toml"), "rb") as f:
        return tomllib.load(f)["project"]


def metadata():
    p = project()
    lines = ["Metadata-Version: 2.1", f"Name: {p['name']}", f"Version: {version()}", f"Summary: {p['description']}",
             f"License: {p['license']['text']}", f"Requires-Python: {p['requires-python']}",
             *(f"Requires-Dist: {name}" for name in p["dependencies"])]
    for extra, names in p["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f'Requires-Dist: {name}; extra == "{extra}"' for name in names)]
    lines += ["Description-Content-Type: text/markdown", ""]
    with open(os.path.join(source, p["readme"]), encoding="utf-8") as f:
        return "\n".join(lines) + "\n" + f.read()


def scripts():
    return "[console_scripts]\n" + "".join(f"{k} = {v}\n" for k, v in project()["scripts"].items())


def tag():
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    return f"{python}-{python}-{re.sub(r'[-.]', '_', sysconfig.get_platform())}"


def made(folder):
    """The DEM, built in `folder` for the Python that asks."""
    options = {"CMAKE_BUILD_TYPE": "Release", "GRUS_FEM": "OFF", "GRUS_TESTS": "OFF", "CMAKE_UNITY_BUILD": "ON",
               "Python_EXECUTABLE": sys.executable}
    more = shlex.split(os.environ.get("CMAKE_ARGS", ""))  # of conda: its compilers and where its libraries are
    asked = [f"-D{key}={value}" for key, value in options.items()]
    subprocess.run(["cmake", "-S", source, "-B", folder, *more, *asked], check=True)
    cores = str(len(os.sched_getaffinity(0)))  # make without a number would begin all at once
    subprocess.run(["cmake", "--build", folder, "--parallel", cores, "--target", "grus-rve", "grus_python"], check=True)
    return folder


def files_of(build):
    """(name in the wheel, path) of all that is installed."""
    package = os.path.join(build, "python", "grus")
    for folder, _, names in sorted(os.walk(package)):
        for name in sorted(names):
            path = os.path.join(folder, name)
            other = name.endswith(".so") and not name.endswith(sysconfig.get_config_var("EXT_SUFFIX"))
            if not name.endswith(".pyc") and not other:  # a core built for another Python
                yield "grus/" + os.path.relpath(path, package), path
    for program in PROGRAMS:
        path = os.path.join(build, "bin", program)
        if os.path.exists(path):
            yield f"grus-{version()}.data/scripts/{program}", path
    yield f"grus-{version()}.dist-info/LICENSE", os.path.join(source, "LICENSE")


def about():
    """Texts of the folder dist-info."""
    kind = f"Wheel-Version: 1.0\nGenerator: grus\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {"METADATA": metadata(), "entry_points.txt": scripts(), "WHEEL": kind}


def digest(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def wheel(build, path):
    place, record = f"grus-{version()}.dist-info", []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as z:
        def add(name, data, mode=0o644):
            info = zipfile.ZipInfo(name)
            info.external_attr, info.compress_type = (0o100000 | mode) << 16, zipfile.ZIP_DEFLATED
            z.writestr(info, data)
            record.append(f"{name},{digest(data)},{len(data)}\n")
        for name, file in files_of(build):
            with open(file, "rb") as f:
                add(name, f.read(), 0o755 if "/scripts/" in name else 0o644)
        for name, text in about().items():
            add(f"{place}/{name}", text.encode())
        z.writestr(f"{place}/RECORD", "".join(record) + f"{place}/RECORD,,\n")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Told before anything is compiled."""
    name = f"grus-{version()}.dist-info"
    os.makedirs(os.path.join(metadata_directory, name))
    for file, text in about().items():
        with open(os.path.join(metadata_directory, name, file), "w", encoding="utf-8") as f:
            f.write(text)
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"grus-{version()}-{tag()}.whl"
    there = (config_settings or {}).get("build-dir")
    with tempfile.TemporaryDirectory() as folder:
        build = os.path.abspath(there) if there else made(folder)
        if not os.path.exists(os.path.join(build, "bin", "grus-rve")):
            raise SystemExit(f"build-dir={there}: no grus-rve in its bin: build it first, or leave the setting out")
        wheel(build, os.path.join(wheel_directory, name))
    return name


def build_sdist(sdist_directory, config_settings=None):
    name = f"grus-{version()}"
    leave = lambda entry: None if "__pycache__" in entry.name else entry
    with tarfile.open(os.path.join(sdist_directory, name + ".tar.gz"), "w:gz") as tar:
        for part in SHIPPED:
            tar.add(os.path.join(source, part), f"{name}/{part}", filter=leave)
        told = tarfile.TarInfo(f"{name}/PKG-INFO")
        data = metadata().encode()
        told.size = len(data)
        tar.addfile(told, io.BytesIO(data))
    return name + ".tar.gz"
