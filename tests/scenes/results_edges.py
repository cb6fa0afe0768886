#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders and what callers give, read or refused in one line, without a program: results_edges.py BIN"""
import json
import math
import os
import pathlib
import pickle
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus import asked, results  # noqa: E402
from grus.errors import InputError  # noqa: E402
from grus.files import folders, summary_keys, tables, texts, writing  # noqa: E402

import scene_tools  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def refused(words, work, kind=InputError):
    scene_tools.refused(words, work, kind)


def write(folder, **files):
    os.makedirs(folder, exist_ok=True)
    for name, text in files.items():
        with open(os.path.join(folder, name.replace("_", ".")), "w") as f:
            f.write(text)
    return str(folder)


def runs(tmp):
    """A results folder as Results, its parts, and damaged ones."""
    grading = "strain,diameter_m,passing\n0.0,1e-3,0.25\n0.0,2e-3,1\n0.1,1e-3,0.5\n"
    good = write(os.path.join(tmp, "good"), history_csv="a,b\n1,\n2,5\n", grading_csv=grading, summary_json=json.dumps(
        {"status": 0, "deep": {"x": 1}, "files": ["history.csv", "grading.csv"]}))
    r = results.load(pathlib.Path(good))
    need(list(r) == ["a", "b"] and len(r) == 2 and list(r["a"]) == [1, 2] and math.isnan(r["b"][0]) and
         r["b"][1] == 5 and r.status == 0 and r.folder == good, "columns of a run")
    need(r.summary["deep"]["x"] == 1 and list(r.grading) == [0.0, 0.1] and list(r.grading[0.0]["passing"]) ==
         [0.25, 1] and list(r.grading[0.1]["diameter_m"]) == [1e-3], f"its summary and grading: {r.grading}")
    refused([f"{good}: history.csv: no 'c'", "there are a, b"], lambda: r["c"], asked.Lacking)
    refused([f"{good}: summary.json: no 'dep'", "did you mean 'deep'?"], lambda: r.summary["dep"], asked.Lacking)
    refused(f"{good}: summary.json: no 'y'", lambda: r.summary["deep"]["y"], asked.Lacking)
    refused(f"{good}: grading.csv: no 0.2; there are 0.0, 0.1", lambda: r.grading[0.2], asked.Lacking)
    refused("grading.csv: no 'x'", lambda: r.grading[0.0]["x"], asked.Lacking)
    need(r.frame().shape == (2, 2), "a frame")
    for status, word in ((0, "finished"), (3, "unstable"), (1, "unfinished"), (None, "unfinished")):
        folder = write(os.path.join(tmp, f"ended{status}"), history_csv="a,b,c\n1,2,3\n4,5,6\n",
         summary_json=json.dumps(
            {} if status is None else {"status": status}))
        need(repr(results.load(folder)) == f"<grus.Results of {folder}: 2 rows of 3 columns, {word}>",
             repr(results.load(folder)))
        need(results.read_grading(folder) == {} == results.load(folder).grading, "a run without a grading")
    need(results.read_grading(good, ["history.csv"]) == {} and set(results.read_grading(good)) == {0.0, 0.1} ==
         set(results.read_grading(good, "no list")), "a grading of a run before is none of this one")
    whole = results.read_run(good)
    need(whole["columns"]["a"] == [1, 2] and whole["summary"]["status"] == 0 and whole["grading"][0.1] ==
         [{"strain": 0.1, "diameter_m": 1e-3, "passing": 0.5}], f"what studies read: {whole}")
    bad = os.path.join(tmp, "bad")
    for text, words in (("a,b\n", "no rows"), ("", "no rows"), ("a,b\n1\n", "line 2 has 1 values for 2 columns"),
                        ("a,b\n1,2\n3,x\n", "line 3: b is not a number"), ("a,b\n1,2,3\n", "line 2 has 3 values"),
                        ("a\n" + "1" * 200000 + "\n", "not a table")):
        write(bad, history_csv=text, summary_json='{"status": 0}')
        refused([f"{bad}/history.csv", words], lambda: results.load(bad))
    with open(os.path.join(bad, "history.csv"), "wb") as f:
        f.write(b"a\n\xff\xfe\n")
    refused([f"{bad}/history.csv: not a table"], lambda: results.load(bad))
    damaged = {"": "not JSON", "[1]": "not a summary of Grus", "[" * 100000: "not JSON", "{": "not JSON"}
    for text, words in damaged.items():
        write(bad, history_csv="a\n1\n", summary_json=text)
        refused([f"{bad}/summary.json: {words}"], lambda: results.load(bad))
    os.remove(os.path.join(bad, "summary.json"))
    refused([f"{bad}: no results of Grus: No such file", "summary.json"], lambda: results.load(bad))
    write(bad, summary_json="{}", grading_csv="strain,x\n1,y\n")
    refused([bad, "could not convert"], lambda: results.load(bad))
    refused("folder: expected a path", lambda: results.load(3))


def names():
    """What is not there, and what is near it."""
    said = lambda name, *known: str(asked.Lacking("w", name, known))
    need(said("peek", "peak", "none") == "w: no 'peek'; did you mean 'peak'?" and said("ABC", "abd", "abe") ==
         "w: no 'ABC'; did you mean 'abe' or 'abd'?" or said("ABC", "abd", "abe") ==
         "w: no 'ABC'; did you mean 'abd' or 'abe'?", said("ABC", "abd", "abe"))
    need(said("str", "axial_stress_Pa", "x") == "w: no 'str'; did you mean 'axial_stress_Pa'?", said("str", "x"))
    need(said("a", "xa1", "xa2", "xa3", "xa4").count("or") == 2, "three at most")
    need(said("", "x") == "w: no ''; there are x" and said(3, 1, 2) == "w: no 3; there are 1, 2" and said("q") ==
         "w: no 'q'; there are none", "what is there")
    d = pickle.loads(pickle.dumps(asked.Named("w", {"a": 1})))
    need(d == {"a": 1} and isinstance(d, asked.Named), "a dict that is sent")
    refused("w: no 'b'", lambda: d["b"], asked.Lacking)
    kinds = [asked.kind(v) for v in (1.5, True, None, "x", [1], np.zeros((2, 3)), np.int32(4))]
    need(kinds == ["float 1.5", "bool True", "NoneType None", "str", "list", "float64 array of shape (2, 3)", "int32"],
         f"{kinds}")


def given():
    """Paths, changes, numbers, settings, increments and room."""
    need(asked.path_of("p", pathlib.Path("a")) == "a" and asked.path_of("p", "b") == "b", "paths")
    for value, words in ((3, "p: expected a path, given int 3"), (b"x", "given bytes"), ("", "it is empty"),
                         ("a\0", "a zero byte ends it"), (pathlib.PurePath, "expected a path")):
        refused(words, lambda: asked.path_of("p", value))
    need(asked.changes_of(("a=1", "b=")) == ["a=1", "b="] and asked.changes_of(iter([])) == [], "changes")
    for value, words in (("a=1", "not one text (str)"), (b"a", "(bytes)"), (None, "(NoneType None)"), ({"a": 1},
        "(dict)"),
                         (["a"], "given 'a' in it"), ([1], "given int 1 in it"), (["a=\0"], "in it")):
        refused(words, lambda: asked.changes_of(value))
    need([asked.whole_number("n", v, 0) for v in (0, np.int64(5), 2**31 - 1)] == [0, 5, 2**31 - 1] and
         asked.whole_number("n", -3, -3) == -3, "whole numbers")
    for value, words in ((-1, "n = -1: expected a whole number from 0 to 2147483647"), (2**31, "n = 2147483648"),
                         (1.0, "given float 1.0"), (True, "given bool True"), (np.True_, "n: expected"), ("1", "str")):
        refused(words, lambda: asked.whole_number("n", value, 0))
    text = asked.settings_text({"a": 1, "b": 2.5, "c": True, "d": "x\"", "e": {"f": np.float64(0.5)}, "g": np.int32(7)})
    need(text == 'a = 1\nb = 2.5\nc = true\nd = "x\\""\ne = { f = 0.5 }\ng = 7', f"{text}")
    for value, words in (({"a b": 1}, "unknown key 'a b'"), ({"a": {"ä": 1}}, "unknown key a.'ä'"), ({1: 2}, "key 1"),
                         ({"a": [1]}, "a: expected a number"), ({"a": {"b": None}}, "a.b: expected")):
        refused(words, lambda: asked.settings_text(value))
    one = np.arange(18.0).reshape(2, 3, 3)
    for same in (one, one.reshape(2, 9), one.reshape(-1), one.reshape(1, 2, 3, 3), one.astype(int), one.tolist()):
        need((asked.increments_of(same, 2) == np.arange(18)).all(), "increments of any form")
    need(np.shares_memory(asked.increments_of(one, 2), one), "increments are copied")
    need(asked.increments_of(np.zeros((0, 3, 3)), 0).size == 0, "no increments")
    masked = np.ma.array(one, mask=one == 3)
    for value, words in ((one[:1], "(2, 3, 3), given (1, 3, 3) of float64"), (one.transpose(1, 2, 0),
        "given (3, 3, 2)"),
                         ([[1], [1, 2]], "rows of different lengths"), (masked, "masked"), (one > 1, "of bool"),
                         (one.astype(complex), "complex"), (one.reshape(9, 2), "given (9, 2)")):
        refused(words, lambda: asked.increments_of(value, 2))
    need((asked.increments_of(np.ma.array(one), 2) == one.ravel()).all(), "nothing is masked")
    for shape in ((2, 6), (12,), (1, 2, 6)):
        room = np.zeros(shape)
        found = asked.room_in("s", room, 2, (6,))
        need(found.shape == (12,) and np.shares_memory(found, room), "room to be written in")
    need(asked.room_in("s", np.zeros((2, 36)), 2, (6, 6)).shape == (72,), "rows of a matrix")
    locked, gaps = np.zeros((2, 6)), np.zeros((2, 12))[:, ::2]
    locked.flags.writeable = False
    for value, words in (([0.0] * 12, "given list"), (np.zeros((2, 6), np.float32), "float32"), (locked, "writable"),
                         (np.ma.zeros((2, 6)), "NumPy array"), (gaps, "without gaps"), (np.zeros(11),
                          "11 numbers, expected 12"),
                         (np.zeros((6, 2)), "shape (6, 2), expected (2, 6) or one row of 12"),
                         (np.zeros((3, 4)), "points come first")):
        refused(words, lambda: asked.room_in("s", value, 2, (6,)))

    class Comm:
        rank = size = allgather = scatter = send = recv = 0
    need(asked.communicator(None) is None and asked.communicator(Comm) is Comm, "communicators")
    refused(["comm: expected a communicator", "int 1"], lambda: asked.communicator(1))
    need(asked.state_bytes(bytearray(b"ab")) == b"ab" == asked.state_bytes(memoryview(b"ab")), "states")
    refused("state: expected the bytes of get_state, given str", lambda: asked.state_bytes("ab"))


def files(tmp):
    """Files written whole, folders that are marked and locked, texts in any encoding."""
    path = os.path.join(tmp, "a")
    with open(path + ".new", "w") as f:
        f.write("of somebody")
    writing.write_whole(path, "text"), writing.write_whole(path, b"bytes")
    need(open(path).read() == "bytes" and os.listdir(tmp) == ["a"], "a file written whole")
    refused("", lambda: writing.write_whole(os.path.join(tmp, "no", "a"), "x"), FileNotFoundError)
    os.mkdir(os.path.join(tmp, "taken"))
    refused("", lambda: writing.write_whole(os.path.join(tmp, "taken"), "x"), IsADirectoryError)
    need(sorted(os.listdir(tmp)) == ["a", "taken"], "what could not be written is left")
    os.symlink(path, path + ".new")
    writing.write_whole(os.path.join(tmp, "a"), "again")
    need(open(path).read() == "again" and not os.path.islink(path), "a link is followed")
    writing.write_csv(path, [["a", math.nan], [1.5, "b,c"]])
    need(open(path).read() == 'a,\n1.5,"b,c"\n', "a number that is not there")
    out = os.path.join(tmp, "out")
    with folders.Folder(out):
        refused("another run is writing", lambda: folders.Folder(out).__enter__(), folders.InUse)
        need(os.path.isfile(os.path.join(out, ".grus")), "a folder without a mark")
    with folders.Folder(out):
        pass
    refused("is a file", lambda: folders.Folder(path).__enter__(), folders.InUse)
    refused("was not made by Grus", lambda: folders.Folder(tmp).__enter__(), folders.InUse)
    with folders.Folder(os.path.join(tmp, "taken")):
        need(os.path.isfile(os.path.join(tmp, "taken", ".grus")), "an empty folder may be taken")
    os.makedirs(os.path.join(tmp, "linked")), os.symlink(path, os.path.join(tmp, "linked", ".grus"))
    refused("was not made by Grus", lambda: folders.Folder(os.path.join(tmp, "linked")).__enter__(), folders.InUse)
    refused("cannot write: Not a directory", lambda: folders.Folder(os.path.join(path, "x")).__enter__(), folders.InUse)
    folders.note_result(out, "r.html"), folders.note_result(out, "r.html"), folders.note_result(out, "s.html")
    need(open(os.path.join(out, ".grus")).read() == "r.html\ns.html\n", "what is noted, once")
    folders.note_result(tmp, "x")
    need(not os.path.exists(os.path.join(tmp, ".grus")), "a folder that is not Grus's is marked")
    write(out, a_csv="", b_csv=""), write(os.path.join(out, "plots"), p_png="", q_txt="")
    os.symlink("nowhere", os.path.join(out, "dead"))
    folders.clear_results(out, ["a.csv", "none", "dead"])
    need(sorted(os.listdir(out)) == [".grus", "b.csv", "plots"] and os.listdir(os.path.join(out, "plots")) == ["q.txt"],
         f"what is cleared: {os.listdir(out)}")
    folders.clear_results(tmp, ["none"])
    for raw, text in (("ä".encode(), "ä"), ("ä".encode("utf-8-sig"), "ä"), ("ä".encode("utf-16"), "ä"),
                      (b"\xe4", "ä")):
        with open(path, "wb") as f:
            f.write(raw)
        need(texts.text_of(path) == text, f"{raw}: {texts.text_of(path)}")
    for raw in (b"a\0b", b"\xff\xfea", b"\x81"):
        with open(path, "wb") as f:
            f.write(raw)
        refused(f"cannot read {path}: not a text file", lambda: texts.text_of(path), texts.BadData)
    for mark in (b"\x1f\x8b\x08", b"PK\3\4", b"BZh9", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd"):
        with open(path, "wb") as f:
            f.write(mark + b"a = 1\n")
        refused(f"cannot read {path}: the file is compressed", lambda: texts.text_of(path), texts.BadData)
        refused("the file is compressed; unpack it first", lambda: texts.toml_of(path), ValueError)
    refused("cannot read none: No such file", lambda: texts.text_of("none"), texts.BadData)
    with open(path, "wb") as f:
        f.write('a = "ä"'.encode("utf-16"))
    need(texts.toml_of(path) == {"a": "ä"} and texts.one_line("a\nb\tc\x7f") == "a b c ", "texts")
    need(texts.text_table(["a", "bcd"], [[123, "x"], ["y", ""]]) == "a    bcd\n123  x\ny\n", "columns side by side")
    rows = summary_keys.table()
    need(all(row.program in ("rve", "bvp", "both") and row.meaning for row in rows) and
         set(summary_keys.keys_of("rve")) | set(summary_keys.keys_of("bvp")) == {row.path for row in rows}, "keys")
    known = summary_keys.known
    need(known("counts.grains", "rve") and not known("counts.grains", "bvp") and known("scene.any.key", "bvp") and
         known("title", "rve") and not known("titles", "rve") and not known("scene", "rve"), "who writes which key")


def units():
    """Ranges as people read them, separators, names with their units."""
    for values, name, text in (([1e6, 2e9], "s_Pa", "0.001 … 2 GPa"), ([5.0], "s_Pa", "5 … 5 Pa"), ([0.0], "d_m",
        "0 … 0 µm"),
                               ([1e3, 2e3], "s_Pa", "1 … 2 kPa"), ([-1e-3, 5e-4], "d_m", "-1 … 0.5 mm"),
                               ([1.0, 2.0], "x", "1 … 2"), ([1e6], "s_Pa", "1 … 1 MPa")):
        need(tables.range_text(values, name) == text, f"{values}: {tables.range_text(values, name)}")
    for head, found in (("a [mm]", ("a", "mm")), ("a (x) (mm)", ("a (x)", "mm")), ("a / s", ("a", "s")), ("a/s",
        ("a/s", None)),
                        ("a in s", ("a", "s")), ("[mm]", ("[mm]", None)), ("a []", ("a", ""))):
        need(tables.name_and_unit(head) == found, f"{head}: {tables.name_and_unit(head)}")
    need([tables.kind_of(n) for n in ("s_Pa", "rate_1_s", "d_m", "x", "t_s")] == ["Pa", "1_s", "m", "1", "s"], "kinds")
    need([tables.is_number(t) for t in ("1", "-1.5e3", ".5", "1.", "1,5", "x", "")] == [True] * 4 + [False] * 3 and
         tables.is_number("1,5", True) and not tables.is_number("1.5", True), "numbers")


def read(tmp):
    """Tables: their separators, comments, quotes, units in names, and what is wrong with them, by line and column."""
    path = os.path.join(tmp, "t.csv")

    def columns(text, *names, optional=(), quantity=None):
        with open(path, "w") as f:
            f.write(text)
        return tables.read_columns(path, names, optional, quantity)
    for text, found in (("sep=;\nx;y\n1;2\n", [[1], [2]]), ("# c\n\nx,y\n# c\n1,2\n\n", [[1], [2]]),
                        ("x\ty\n1\t2\n", [[1], [2]]), ("x y\n1 2\n3 4\n", [[1, 3], [2, 4]]),
                        ("x;y\n1,5;2,25\n", [[1.5], [2.25]]), ("x,y,\n1,2,\n", [[1], [2]]),
                        ('"x", \'y\'\n"1", 2\n', [[1], [2]]), ("y [%],x [-]\n50,2\n", [[2], [0.5]]),
                        ("y,z,x\n1e1,q,-.5\n", [[-0.5], [10]]), ("x , y\n1 , 2\n", [[1], [2]])):
        need(columns(text, "x", "y") == found, f"{text!r}: {columns(text, 'x', 'y')}")
    need(columns("v\n1,5\n", "v") == [[1.5]] and columns("v\n1,5\n2,25\n", "v") == [[1.5, 2.25]],
        "decimal commas alone")
    need(columns("d_mm,f_kN\n1,2\n", "d_m", "f_N") == [[1e-3], [2e3]] and columns("t [min],x\n2,1\n", "t_s", "x") ==
         [[120], [1]] and columns("x,value_MPa\n1,20\n", "x", "value", quantity="s_Pa") == [[1], [2e7]],
          "units in names")
    need(columns("x,y,error\n1,2,3\n", "x", "y", optional=["error"]) == [[1], [2], [3]] and
         columns("x,y\n1,2\n", "x", "y", optional=["error"]) == [[1], [2], None], "columns that may be there")
    need(columns("x,y_Pa [kPa],error [MPa]\n1,20,3\n", "x", "y_Pa", optional=["error"]) == [[1], [2e4], [3e6]],
        "of errors")
    need(columns("min,max\n1,2\n", "min", "max") == [[1], [2]], "the least and the largest are names")
    need(columns("s_Pa\n1\n", "s_Pa") == [[1]] and columns("s [MPa]\n1e-4\n", "s_Pa") == [[100]] and
         columns("s\n0\n", "s", quantity="s_Pa") == [[0]], "stresses whose unit is told")
    for text, words in (("", ": is empty"), ("x,y\n", ": no rows"), ("x,y\n1\n", ":2: 1 values under 2 names"),
                        ("x\n1;2\n", ":2: "), ("x,y\n1,5,2\n", "';' must part the columns"), ("1,2\n3,4\n",
                         ":1: the columns"),
                        ("x,mm,y\n1,2,3\n", "write the unit in brackets, 'x [mm]'"), ("x,min,y\n1,2,3\n", "'x [min]'"),
                        ("x,y\n1,\n", ":2: column 'y': no value"), ("x,y\n1,a\n", ":2: column 'y': 'a' is no number"),
                        ("x,y\n1,1e999\n", "'1e999' is not finite"), ("x,x\n1,2\n", "two columns are called 'x'"),
                        ("x,z\n1,2\n", ":1: no column is called 'y'; there are 'x', 'z'"),
                        ("x,yy\n1,2\n", "'y'"), ("x,y [q]\n1,2\n", "unit 'q' is not known"),
                        ("x,y [mm]\n1,2\n", "'mm' is no unit of y"), ('x,y\n1,"2\n', "not a line of a table"),
                        ("x;y\n1.5;2,5\n", "'1.5' has a point, '2,5' a comma"),
                        ("x;y\n1;2,500\n", "may be a decimal comma or a mark of thousands")):
        refused([path, words], lambda: columns(text, "x", "y"), texts.BadData)
    refused("did you mean 'yield'", lambda: columns("x,yield\n1,2\n", "x", "yeld"), texts.BadData)
    for head in ("Error", "std", "y_err", "error_y", "errors", "eror"):
        refused(f"column '{head}': did you mean 'error'?", lambda: columns(f"x,y,{head}\n1,2,3\n", "x", "y", optional=[
            "error"]), texts.BadData)
    refused("needs its unit, as 'y [mm]' has one", lambda: columns("x,y [mm],error\n1,2,3\n", "x", "y",
        optional=["error"],
                                                                   quantity="y_m"), texts.BadData)
    refused("without a unit its largest value would be 9999 Pa", lambda: columns("s\n9999\n", "s", quantity="s_Pa"),
            texts.BadData)
    need(columns("s\n10000\n", "s", quantity="s_Pa") == [[1e4]], "as large as stresses are")
    with open(path, "w") as f:
        f.write("a [mm],b\n1,2\n")
    of = tables.Columns(path, {"b": "b"})
    need(of["b"] == [2] and tables.Columns(path)["a_m"] == [1e-3], "columns that are asked for by and by")


names()
given()
units()
for of in (runs, files, read):
    with tempfile.TemporaryDirectory() as place:
        of(place)
print(f"results_edges: {len(faults)} faults")
sys.exit(bool(faults))
