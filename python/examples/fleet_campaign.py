#!/usr/bin/env python3
"""A campaign over a cluster of Ray, or over this machine where there is none.

    python examples/fleet_campaign.py FINGERPOST OUT

FINGERPOST is the program, OUT a folder for the results.
"""

import sys

from fingerpost import fleet


def main(program, out):
    table = fleet.campaign(2, out, conditions=["clear", "shadows"], size=(120, 90), fps=4.0, program=program)
    counts = [("features_total", "sum"), ("features_detected", "sum"), ("false_detections", "sum")]
    for row in table.group_by("conditions").aggregate(counts).to_pylist():
        print(row)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
