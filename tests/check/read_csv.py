#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads a csdtrackenc CSV with Python's own reader: prints a line per row, values in Python's own form."""
import csv
import sys

with open(sys.argv[1], newline="", encoding="utf-8") as file:
    for row in csv.DictReader(file, strict=True):
        print(int(row["frame"]), row["pts"] and int(row["pts"]),
              row["stream_time"] and int(row["stream_time"]), int(row["id"]), float(row["x"]),
              float(row["y"]), row["state"], float(row["confidence"]), row["fresh"], len(row))
