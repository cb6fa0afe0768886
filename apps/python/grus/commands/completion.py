# SPDX-License-Identifier: LGPL-3.0-or-later
"""What bash and zsh need to complete grus and the programs that it hands on to; made from the words of the command."""
from grus.commands.words import FRAMES, KINDS, PROBLEMS, RUN, SHELLS, WORDS

PROGRAMS = {
    "grus-rve": {**RUN, "--keys": "", "--schema": "", "--new": "NEW", "--version": ""},
    "grus-bvp": {**RUN, "--keys": "", "--schema": "", "--new": "PROBLEM", "--version": ""},
    **{f"grus-{w.program}": {**w.options, "--version": ""} for w in WORDS.values() if w.program}
}
# What a place wants, as the function of each script gives it.
PLACES = {"SCENE.toml": "toml", "FILE.toml": "toml", "STUDY.toml": "toml", "CALIBRATION.toml": "toml", "DIR": "folders",
          "DIR...": "folders", "FILE": "files", "KEY=VALUE": "keys", "KIND [SCENE.toml]": "new", "NEW": "kinds",
          "PROBLEM": "problems", "KIND": "frames", "SHELL": "shells"}
LISTS = {"new": {**KINDS, **PROBLEMS}, "kinds": KINDS, "problems": PROBLEMS, "frames": FRAMES, "shells": SHELLS}

BASH = r"""# bash completion of grus and its programs: made by grus completion bash
_grus_keys() { grus-rve --keys 2>/dev/null | sed -n 's/^\([a-z_]*\(\.[a-z_]*\)*\)$/\1=/p'; }
_grus_place() {
  case $1 in
    toml) compopt -o filenames; COMPREPLY=($(compgen -f -X '!*.toml' -- "$cur") $(compgen -d -- "$cur")) ;;
    folders) compopt -o filenames; COMPREPLY=($(compgen -d -- "$cur")) ;;
    files) compopt -o filenames; COMPREPLY=($(compgen -f -- "$cur")) ;;
    keys) compopt -o nospace; COMPREPLY=($(compgen -W "$(_grus_keys)" -- "$cur")) ;;
@LISTS@
  esac
}
_grus() {
  local cur=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} word=${COMP_WORDS[0]##*/} options= place=
  COMPREPLY=()
  if [[ $word == grus ]]; then
    if ((COMP_CWORD == 1)); then
      COMPREPLY=($(compgen -W "@WORDS@ --help --version" -- "$cur"))
      return
    fi
    word="grus ${COMP_WORDS[1]}"
  fi
  case $word in
@CASES@
  esac
  case "$word $before" in
@VALUES@
    *) if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W "$options" -- "$cur")); else _grus_place "$place"; fi ;;
  esac
}
complete -F _grus grus @PROGRAMS@
"""
ZSH = r"""#compdef grus @PROGRAMS@
# zsh completion of grus and its programs: made by grus completion zsh
_grus_keys() {
  local -a names=(${(f)"$(grus-rve --keys 2>/dev/null | sed -n 's/^\([a-z_]*\(\.[a-z_]*\)*\)$/\1=/p')"})
  compadd -S '' -- $names
}
_grus() {
  local word=${words[1]:t}
  if [[ $word == grus ]]; then
    if ((CURRENT == 2)); then
      local -a commands=(
@DESCRIBED@
      )
      _describe command commands
      return
    fi
    word="grus $words[2]"
    shift words
    ((CURRENT--))
  fi
  case $word in
@ARGUMENTS@
  esac
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _grus "$@"; else compdef _grus grus @PROGRAMS@; fi
"""


def all_words() -> list[tuple[str, str, dict[str, str]]]:
    """(command, what it is given, options) of each that is completed."""
    given = {f"grus-{w.program}": w.given for w in WORDS.values() if w.program}
    return ([(f"grus {name}", w.given, w.options) for name, w in WORDS.items()]
            + [(name, given.get(name, "SCENE.toml"), options) for name, options in PROGRAMS.items()])


def bash() -> str:
    lists = [f'    {name}) COMPREPLY=($(compgen -W "{" ".join(of)}" -- "$cur")) ;;' for name, of in LISTS.items()]
    cases = [f'    "{name}") options="{" ".join(options)}" place={PLACES.get(given, "")} ;;'
             for name, given, options in all_words()]
    values = [f'    "{name} {option}") _grus_place {PLACES.get(wants, "none")} ;;'
              for name, _, options in all_words() for option, wants in options.items() if wants]
    return filled(BASH, LISTS=lists, CASES=cases, VALUES=values)


ACTIONS = {"toml": '_files -g "*.toml"', "folders": "_files -/", "files": "_files", "keys": "_grus_keys",
           **{name: f"({' '.join(of)})" for name, of in LISTS.items()}}


def zsh() -> str:
    action = lambda wants: ACTIONS.get(PLACES.get(wants, ""), " ")
    described = [f"        '{name}:{word.about.replace(':', chr(92) + ':')}'" for name, word in WORDS.items()]
    arguments = []
    for name, given, options in all_words():
        more = "*" if given in ("DIR...",) else "1"
        specs = [f"'{option}[{wants or 'no value'}]" + (f":{wants}:{action(wants)}'" if wants else "'")
                 for option, wants in options.items()]
        specs.append(f"'{more}:{given}:{action(given)}'")
        arguments.append(f'    "{name}") _arguments ' + " ".join(specs) + " ;;")
    return filled(ZSH, DESCRIBED=described, ARGUMENTS=arguments)


def filled(text: str, **parts: list[str]) -> str:
    for name, lines in {**parts, "WORDS": [" ".join(WORDS)], "PROGRAMS": [" ".join(PROGRAMS)]}.items():
        text = text.replace(f"@{name}@", "\n".join(lines))
    return text


def script(shell: str) -> str:
    """For `shell`: bash or zsh."""
    return bash() if shell == "bash" else zsh()
