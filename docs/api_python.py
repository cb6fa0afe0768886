# SPDX-License-Identifier: LGPL-3.0-or-later
"""The page of the Python interface: every public name once, from signatures and docstrings, which are read and not
run. (Debian 12's mkdocstrings knows no signature of a data class, of which the package has many.)"""
import ast
import os
import re

TITLES = {"grus.rves": "RVEs of Gauss points", "grus.samples": "Samples without a scene file", "grus.runs.run": "Runs",
          "grus.runs.scene": "Scenes", "grus.results": "Results", "grus.frames": "Frames", "grus.bands": "Bands",
          "grus.errors": "Errors", "grus.precice": "preCICE"}
SECTIONS = {"Args": ("argument", "kind", "default"), "Attributes": ("attribute",), "Raises": ("raises",)}


def plain(text):
    """Words of a docstring as Markdown takes them: what is not in backticks is no markup."""
    parts = re.split(r"(`[^`\n]+`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([<>&*_\[|])", r"\\\1", part).replace(r"\<", "&lt;")
                   .replace(r"\&", "&amp;").replace(r"\>", "&gt;").replace(r"\|", "&#124;") for part in parts)


def joined(lines):
    return " ".join(line.strip() for line in lines)


def sections(doc):
    """(text, {section: lines}) of a docstring of Google's style."""
    parts = re.split(r"^(Args|Attributes|Returns|Raises):$", doc or "", flags=re.M)
    return parts[0].strip(), {name: re.sub(r"^ {4}", "", body.strip("\n"), flags=re.M)
                              for name, body in zip(parts[1::2], parts[2::2])}


def entries(body):
    """(name, words) of a section's entries; what is further in goes on."""
    found = re.split(r"^([*\w.]+): ", body, flags=re.M)
    return [(name, joined(words.splitlines())) for name, words in zip(found[1::2], found[2::2])]


def arguments(node):
    """name -> (text before its name, annotation, default) of a function, or of a data class, whose fields they are."""
    if isinstance(node, ast.ClassDef):
        fields = [f for f in node.body if isinstance(f, ast.AnnAssign) and not f.target.id.startswith("_")]
        return {f.target.id: ("", ast.unparse(f.annotation), f.value and ast.unparse(f.value)) for f in fields}
    a, found = node.args, {}
    plain_ones = a.posonlyargs + a.args
    defaults = [None] * (len(plain_ones) - len(a.defaults)) + a.defaults
    pairs = [*zip(plain_ones, defaults), *zip(a.kwonlyargs, a.kw_defaults)]
    named = [("", *pair) for pair in pairs]
    for stars, argument, default in named + [("**", a.kwarg, None)] * (a.kwarg is not None):
        if argument.arg != "self":
            found[argument.arg] = (stars, argument.annotation and ast.unparse(argument.annotation),
                                   default and ast.unparse(default))
    return found


def signature(name, node):
    """How it is called, on one line where there is room."""
    asked = arguments(node)
    texts = [stars + key + (f": {kind}" if kind else "") + (f" = {default}" if default else "")
             for key, (stars, kind, default) in asked.items()]
    a = None if isinstance(node, ast.ClassDef) else node.args
    first_named = 0 if a is None else len(a.args) - (a.args[:1] != [] and a.args[0].arg == "self")
    if a is None or a.kwonlyargs:
        texts.insert(first_named + len(a.posonlyargs if a else []), "*")
    if a and a.posonlyargs:
        texts.insert(len(a.posonlyargs) - (a.posonlyargs[0].arg == "self"), "/")
    back = "" if a is None or node.returns is None or node.name == "__init__" else f" -> {ast.unparse(node.returns)}"
    line = f"{name}({', '.join(texts)}){back}"
    return line if len(line) < 90 else f"{name}(\n    " + ",\n    ".join(texts) + f",\n){back}"


def told(doc, asked):
    """A docstring as Markdown: words, then a table for each section."""
    text, found = sections(doc)
    out = []
    for part in text.split("\n\n") if text else []:
        code = all(line.startswith("    ") for line in part.splitlines())
        shown = "```python\n" + re.sub("^    ", "", part, flags=re.M) + "\n```"
        out += [shown if code else plain(joined(part.splitlines())), ""]
    for section, body in found.items():
        if section == "Returns":
            out += ["**Returns** " + plain(joined(body.splitlines())), ""]
            continue
        heads = SECTIONS[section]
        heads = (*heads, "is" if section != "Raises" else "when")
        out += ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
        for name, words in entries(body):
            _, kind, default = asked.get(name.lstrip("*"), ("", None, None)) if section == "Args" else ("", None, None)
            cells = [f"`{name}`"] + [f"`{c}`" if c else "" for c in (kind, default)] * (section == "Args")
            out.append("| " + " | ".join([*cells, plain(words)]) + " |")
        out.append("")
    return out


def members(node, owner):
    """Public methods and properties of a class, in their order."""
    out = []
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and not each.name.startswith("_"):
            read = any(isinstance(d, ast.Name) and d.id == "property" for d in each.decorator_list)
            kind = f".{each.name}: {ast.unparse(each.returns)}" if read else signature("." + each.name, each)
            out += [f'#### <a id="{owner}.{each.name}"></a>`.{each.name}`', "", f"```python\n{kind}\n```", "",
                    *told(ast.get_docstring(each), arguments(each))]
    return out


def entry(name, node):
    """A public class or function."""
    out = [f'### <a id="{name}"></a>`{name}`', ""]
    if isinstance(node, ast.FunctionDef):
        return out + [f"```python\n{signature(name, node)}\n```", "", *told(ast.get_docstring(node), arguments(node))]
    maker = next((f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"), None)
    made = maker or (node if any("dataclass" in ast.unparse(d) for d in node.decorator_list) else None)
    asked_for = "Args:" in (ast.get_docstring(node) or "")
    out += [f"```python\n{signature(name, made)}\n```", ""] if made is not None and asked_for else []
    return out + told(ast.get_docstring(node), arguments(made) if made is not None else {}) + members(node, name)


def page(source):
    """By module, as grus/__init__.py names them; and the class that preCICE asks for."""
    folder = os.path.join(source, "apps", "python", "grus")

    def parsed(module):
        with open(os.path.join(folder, *module.split(".")[1:]) + ".py") as f:
            return ast.parse(f.read())

    top = parsed("grus.__init__")
    found = {node.module: [alias.name for alias in node.names] for node in ast.walk(top)
             if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("grus.")}
    found = {**{k: v for k, v in found.items() if "._" not in k}, "grus.precice": ["MicroSimulation"]}
    if set(found) != set(TITLES):
        raise SystemExit(f"docs: modules without a heading, or the other way round: {set(found) ^ set(TITLES)}")
    text, closing = ast.get_docstring(top).rpartition("\n\n")[::2]
    out = ["# Python", "", "Every public name of the package, from its docstrings: `python3 -m pydoc grus` shows the "
           "same. [How to get it, and programs to begin with](library.md#python).", "",
           plain(joined(closing.splitlines())),
           "`Path` is a text or an `os.PathLike`, `Array` a NumPy array of float64.", "",
           "```python", re.sub("^    ", "", text.partition("\n\n")[2], flags=re.M), "```", ""]
    for module, title in TITLES.items():
        home, tree = "grus.precice" if module == "grus.precice" else "grus", parsed(module)
        out += [f"## {title}", "", plain(joined((ast.get_docstring(tree) or "").splitlines())), ""]
        nodes = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        for name in sorted(found[module], key=list(nodes).index):
            out += entry(f"{home}.{name}", nodes[name])
    out += ["## Version", "", '### <a id="grus.__version__"></a>`grus.__version__`', "", "The version as a text.", ""]
    return "\n".join(out)
