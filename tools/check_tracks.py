#!/usr/bin/env python3
"""Reads the tracks that `locate` wrote with readers that others wrote, and compares them with the fix.jsonl beside them.

    tools/check_tracks.py FOLDER_OF_LOCATE

poses_tum.txt and poses_kitti.txt are read by evo, track.gpx by gpxpy: the same rows, times, places and headings, the same lengths.
Needs the packages evo and gpxpy.
"""
import json
import math
import pathlib
import sys

import gpxpy
import numpy
from evo.tools import file_interface

# A place in a file is rounded: centimetres in GPX (1e-7 degrees), tenths of millimetres in pose files.
ROUNDED_M = 0.02
# A plane's metres against those along the ellipsoid, within a map of some kilometres.
PLANE_SHARE = 1e-3
ROUNDED_RAD = 1e-6
ROUNDED_S = 1e-3


def east_north_m(fixes):
    """Metres from the first fix, by the radii of curvature of WGS 84 there."""
    lat, lon = (numpy.radians([fix[axis] for fix in fixes]) for axis in ("lat", "lon"))
    squared = 6.69437999014e-3
    root = math.sqrt(1.0 - squared * math.sin(lat[0]) ** 2)
    meridian, normal = 6378137.0 * (1.0 - squared) / root**3, 6378137.0 / root
    return numpy.column_stack([(lon - lon[0]) * normal * math.cos(lat[0]), (lat - lat[0]) * meridian])


def turned(angle_rad):
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi


def assert_same(what, read, expected, within):
    off = numpy.abs(numpy.asarray(read) - numpy.asarray(expected))
    assert (off <= within).all(), f"{what}: off by {off.max()}"


def main(folder):
    fixes = [json.loads(line) for line in (folder / "fix.jsonl").read_text().splitlines()]
    fixes = [fix for fix in fixes if fix["status"] in ("converged", "coasting")]
    assert len(fixes) > 100, f"only {len(fixes)} rows have a place; locate a longer drive"
    truth_m = east_north_m(fixes)
    heading_rad = numpy.array([fix["heading_rad"] for fix in fixes])
    distance_m = numpy.hypot(*truth_m.T)[:, None]

    tum = file_interface.read_tum_trajectory_file(folder / "poses_tum.txt")
    assert tum.num_poses == len(fixes), f"{tum.num_poses} TUM poses of {len(fixes)} rows"
    valid, details = tum.check()
    assert valid, f"evo says of the TUM poses: {details}"
    assert_same("TUM times", tum.timestamps, [fix["t_s"] for fix in fixes], ROUNDED_S)
    moved_m = tum.positions_xyz[:, :2] - tum.positions_xyz[0, :2]
    assert_same("TUM places", moved_m, truth_m, ROUNDED_M + PLANE_SHARE * distance_m)
    yaw_rad = tum.get_orientations_euler("sxyz")[:, 2]
    assert_same("TUM headings", turned(yaw_rad - heading_rad), 0.0, ROUNDED_RAD)

    kitti = file_interface.read_kitti_poses_file(folder / "poses_kitti.txt")
    assert kitti.num_poses == len(fixes), f"{kitti.num_poses} KITTI poses of {len(fixes)} rows"
    valid, details = kitti.check()
    assert valid, f"evo says of the KITTI poses: {details}"
    assert_same("first KITTI pose", kitti.poses_se3[0], numpy.eye(4), 1e-6)
    # From the first pose, x to the right, y down, z ahead.
    sine, cosine = math.sin(heading_rad[0]), math.cos(heading_rad[0])
    right_ahead_m = moved_m @ numpy.array([[sine, cosine], [-cosine, sine]])
    assert_same("KITTI places", kitti.positions_xyz[:, [0, 2]], right_ahead_m, ROUNDED_M)
    ahead = numpy.array([pose[:3, 2] for pose in kitti.poses_se3])
    turn_rad = numpy.arctan2(-ahead[:, 0], ahead[:, 2])
    assert_same("KITTI headings", turned(turn_rad - (heading_rad - heading_rad[0])), 0.0, ROUNDED_RAD)
    assert abs(kitti.path_length - tum.path_length) < 1e-3 * tum.path_length, "TUM and KITTI paths differ in length"

    with open(folder / "track.gpx", encoding="utf-8") as stream:
        gpx = gpxpy.parse(stream)
    points = [point for track in gpx.tracks for segment in track.segments for point in segment.points]
    assert len(points) == len(fixes), f"{len(points)} GPX points of {len(fixes)} rows"
    read = [{"lat": point.latitude, "lon": point.longitude} for point in points]
    assert_same("GPX places", east_north_m(read), truth_m, ROUNDED_M)
    assert_same("GPX times", [point.time.timestamp() for point in points], [fix["t_s"] for fix in fixes], ROUNDED_S)
    print(f"{len(fixes)} poses over {tum.path_length:.0f} m, GPX {gpx.length_2d():.0f} m in its pieces")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
