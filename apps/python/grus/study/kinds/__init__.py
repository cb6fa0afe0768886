# SPDX-License-Identifier: LGPL-3.0-or-later
"""Kinds of tables of a study's file, in the order of its report. Each is a module:

NAME                     of its tables: [[NAME]]
SCHEMA                   what they may hold (grus.runs.schema)
read(tables, Reading)    its entries; InputError, in one line, where a table says what cannot be
cases(entry)             cases that it runs itself, as grus.runs.runner takes them
asks(entry, [study])     what it reads of runs: (name of a case, columns of history.csv, keys of summary.json)
show(entries, Done)      Shown: what it adds to study.txt and report.html; its CSV files and plots are written

A new kind is a module and a word here.
"""
from grus.study.kinds import case, check, fit, plot, precision, sweep, table

KINDS = (case, precision, sweep, table, fit, check, plot)
