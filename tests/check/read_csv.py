#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads csdtrackenc's CSV with Python's own reader, and prints each row as Python's values."""

import csv
import sys


def main() -> None:
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file, strict=True):
            times = [row[name] and int(row[name]) for name in ("pts", "stream_time")]
            print(int(row["frame"]), *times, int(row["id"]), float(row["x"]), float(row["y"]),
                  row["state"], float(row["confidence"]), row["fresh"], len(row))


if __name__ == "__main__":
    main()
