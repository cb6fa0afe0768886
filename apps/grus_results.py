# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads the tables of a result folder."""
import csv
import math
import os


def read_history(folder):
    """history.csv as columns; an empty field is NaN."""
    path = os.path.join(folder, "history.csv")
    with open(path, newline="") as f:
        rows = list(csv.reader(f))
    if len(rows) < 2:
        raise ValueError(f"{path}: no rows")
    columns = {name: [] for name in rows[0]}
    for row in rows[1:]:
        for name, value in zip(rows[0], row):
            columns[name].append(float(value) if value else math.nan)
    return columns


def read_grading(folder):
    """States of grading.csv, if the scene asked for it: strain -> rows by size class."""
    path = os.path.join(folder, "grading.csv")
    if not os.path.isfile(path):
        return {}
    states = {}
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            states.setdefault(float(row["strain"]), []).append({k: float(v) for k, v in row.items()})
    return states
