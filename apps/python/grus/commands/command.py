# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus COMMAND ...: hands on to the program that does it, with its options, signals and exit status."""
from __future__ import annotations

import os
import runpy
import subprocess
import sys
from typing import NoReturn

from grus._version import __version__
from grus.commands.completion import script
from grus.commands.words import KINDS, PROBLEMS, SHELLS, STUDIES, VALUED, WORDS, help_text
from grus.errors import InputError
from grus.files.texts import one_line, tables_of
from grus.runs.places import hint
from grus.runs.programs import found, program_of, scene_in


def kind_of(table: dict) -> str:
    """Of a TOML file's tables: who runs it."""
    if "calibrate" in table:
        return "grus-calibrate"
    return "grus-study" if any(name in table for name in STUDIES) else program_of(table)


def program_for(arguments: list[str]) -> tuple[str, str]:
    """The program that runs the file among the arguments, and the file. What cannot be read is left to grus-rve, which
    says where it is wrong."""
    scene = scene_in(arguments, VALUED)
    try:
        return kind_of(tables_of(scene)) if scene else "grus-rve", scene
    except InputError:
        return "grus-rve", scene


def become(*command: str) -> NoReturn:
    """This process goes on as that program: its signals and its exit status are this one's."""
    sys.stdout.flush()
    os.execvp(command[0], command)


def module(name: str, arguments: list[str]) -> NoReturn:
    """A command of the package, in this process."""
    sys.argv = [f"grus-{name}", *arguments]
    runpy.run_module(f"grus.{name}", run_name="__main__", alter_sys=True)
    raise SystemExit(0)


def hand_on(program: str, arguments: list[str]) -> NoReturn:
    name = program.removeprefix("grus-")
    if name in WORDS:
        module(name, arguments)
    become(found(program), *arguments)


def run(arguments: list[str]) -> NoReturn:
    ranks, rest = ranks_of(arguments)
    if "--help" in arguments or "-h" in arguments:
        print("grus run SCENE: as grus-rve SCENE, or grus-bvp SCENE where it has a [mesh]; both have these options.\n"
              "--ranks N: grus-bvp on N ranks of MPI (mpirun)\n", flush=True)
        become(found("grus-rve"), "--help")
    program, scene = program_for(rest)
    if program in ("grus-study", "grus-calibrate"):
        word = program.removeprefix("grus-")
        raise InputError(f"{scene}: has many runs: grus {word} {scene}")
    if ranks > 1 and program != "grus-bvp":
        raise InputError(f"--ranks {ranks}: {scene or 'a scene'} has no [mesh]: use --threads")
    before = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    become(*before, found(program), *rest)


def ranks_of(arguments: list[str]) -> tuple[int, list[str]]:
    """What --ranks asks, 1 without it, and all other arguments."""
    arguments = [part for a in arguments for part in (a.split("=", 1) if a.startswith("--ranks=") else [a])]
    if "--ranks" not in arguments:
        return 1, arguments
    at = arguments.index("--ranks")
    text = "".join(arguments[at + 1:at + 2])
    if not text.isdecimal() or not 0 < int(text) < 100000:
        raise InputError(f"--ranks {text}: expected a whole number from 1")
    return int(text), arguments[:at] + arguments[at + 2:]


def check(arguments: list[str]) -> NoReturn:
    if "--help" in arguments or "-h" in arguments:
        print("usage: grus check FILE.toml [--set KEY=VALUE ...] [--threads N]\n\n" + WORDS["check"].about)
        raise SystemExit(0)
    hand_on(program_for(arguments)[0], [*arguments, "--check"])


def keys(arguments: list[str]) -> int:
    """Of both programs where no part is asked for that only one has."""
    if "--help" in arguments or "-h" in arguments:
        print("usage: grus keys [TEXT] [--macro]\n\n" + WORDS["keys"].about
              + "; those that hold TEXT\n--macro: of grus-bvp's scenes")
        return 0
    text = [a for a in arguments if a != "--macro"]
    if len(text) > 1 or any(a.startswith("-") for a in text):
        raise InputError("keys: expected [TEXT] [--macro]")
    if "--macro" in arguments:
        become(found("grus-bvp"), "--keys", *text)
    told = subprocess.run([found("grus-rve"), "--keys", *text], capture_output=True, text=True)
    if told.returncode == 2 and text:  # of a macro problem, perhaps
        become(found("grus-bvp"), "--keys", *text)
    sys.stdout.write(told.stdout), sys.stderr.write(told.stderr)
    return told.returncode


def new(arguments: list[str]) -> int:
    kinds = {**KINDS, **PROBLEMS}
    if not arguments or arguments[0] in ("-h", "--help"):
        print("usage: grus new KIND [SCENE.toml]\n\n" + "\n".join(f"  {k:<14}{v}" for k, v in kinds.items()))
        return 0 if arguments else 2
    if arguments[0] not in kinds:
        raise InputError(f"new: no scene of the kind '{arguments[0]}'; there are {', '.join(kinds)}")
    become(found("grus-bvp" if arguments[0] in PROBLEMS else "grus-rve"), "--new", *arguments)


def completion(arguments: list[str]) -> int:
    if arguments in (["bash"], ["zsh"]):
        print(script(arguments[0]), end="")
        return 0
    print(f"usage: grus completion {'|'.join(SHELLS)}\n\n"
          "bash: eval \"$(grus completion bash)\" in ~/.bashrc; zsh: eval \"$(grus completion zsh)\" in ~/.zshrc,\n"
          "after compinit. An installation below /usr or /usr/local needs neither.")
    return 0 if arguments in (["-h"], ["--help"]) else 2


def report() -> NoReturn:
    """grus-report, where pip has installed it; the two below likewise."""
    module("report", sys.argv[1:])


def study() -> NoReturn:
    module("study", sys.argv[1:])


def calibrate() -> NoReturn:
    module("calibrate", sys.argv[1:])


HERE = {"run": run, "check": check, "keys": keys, "new": new, "completion": completion}


def work(arguments: list[str]) -> int:
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        if len(arguments) > 1 and arguments[0] == "help":
            return work([arguments[1], "--help"])
        print(help_text(__version__), end="")
        return 0 if arguments else 2
    if arguments[0] == "--version":
        print(f"grus {__version__}")
        return 0
    word, rest = arguments[0], arguments[1:]
    if word in HERE:
        return HERE[word](rest)
    if word in WORDS:
        module(word, rest)
    if word.endswith(".toml"):
        raise InputError(f"{word}: to run it: grus run {word}")
    raise InputError(f"no command '{word}'{hint(word, WORDS)}; grus --help lists them")


def main() -> int:
    try:
        return work(sys.argv[1:])
    except InputError as e:
        print(one_line(f"grus: {e}"), file=sys.stderr)
    except OSError as e:
        print(one_line(f"grus: {e.filename}: {e.strerror}"), file=sys.stderr)
    return 2
