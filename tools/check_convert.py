#!/usr/bin/env python3
"""Writes a simulated drive as ROS 2 bags with somebody else's writer, has them converted, and compares what comes out.

    tools/check_convert.py FINGERPOST DRIVE FOLDER

FINGERPOST is the program, DRIVE a folder of `simulate --ppm`, FOLDER a new one to work in. Needs the package rosbags.
"""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tomllib
import xml.etree.ElementTree
import zlib

import numpy
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
T = STORE.types
# When the made-up drive took place, nanoseconds since 1970; no multiple of anything.
BEGAN_NS = 1_700_000_123_456_789_000
# GPS and wheels speak at moments of their own, the GPS already before the camera.
GPS_LATE_S, TWIST_LATE_S = -0.25, 0.013


def stamp(t_s):
    ns = BEGAN_NS + round(t_s * 1e9)
    return ns, T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), "base_link")


def pixels(path):
    magic, size, most, rest = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert (magic, most) == (b"P6", b"255")
    return numpy.frombuffer(rest, numpy.uint8).reshape(height, width, 3)


def png(picture):
    height, width, _ = picture.shape
    rows = b"".join(b"\0" + row.tobytes() for row in picture)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def camera_info(header, camera):
    k, size = camera["intrinsics"], camera["image"]
    matrix = numpy.array([k["fx"], 0, k["cx"], 0, k["fy"], k["cy"], 0, 0, 1])
    projection = numpy.array([k["fx"], 0, k["cx"], 0, 0, k["fy"], k["cy"], 0, 0, 0, 1, 0.0])
    region = T["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    lens = numpy.array(camera["distortion"]["coefficients"][:5])
    return T["sensor_msgs/msg/CameraInfo"](
        header, size["height"], size["width"], "plumb_bob", lens, matrix, numpy.eye(3).ravel(), projection, 0, 0, region)


def vector(x=0.0, y=0.0, z=0.0):
    return T["geometry_msgs/msg/Vector3"](x, y, z)


def write_bag(path, drive, truth, camera, kind):
    """A bag of raw pictures with a twist, or of packed ones with odometry and an inertial unit; and a second camera."""
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {}

        def send(topic, name, t_s, message):
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=STORE)
            # Messages are recorded some milliseconds after they were sent.
            writer.write(topics[topic], BEGAN_NS + round((t_s + 0.004) * 1e9), STORE.serialize_cdr(message, name))

        for i, row in enumerate(truth):
            t_s = row["t_s"]
            for late_s in (GPS_LATE_S, TWIST_LATE_S):
                _, header = stamp(t_s + late_s)
                twist = T["geometry_msgs/msg/Twist"](vector(row["speed_mps"]), vector(z=row["yaw_rate_rps"]))
                if late_s == GPS_LATE_S:
                    status = T["sensor_msgs/msg/NavSatStatus"](-1 if i == 5 else 0, 1)
                    fix = T["sensor_msgs/msg/NavSatFix"](header, status, row["lat"], row["lon"], 450.0, numpy.zeros(9), 0)
                    send("/fix", fix.__msgtype__, t_s + late_s, fix)
                elif kind == "raw":
                    sent = T["geometry_msgs/msg/TwistStamped"](header, twist)
                    send("/vehicle/twist", sent.__msgtype__, t_s + late_s, sent)
                else:
                    turned = T["geometry_msgs/msg/Twist"](vector(row["speed_mps"]), vector(z=9.0))
                    pose = T["geometry_msgs/msg/Pose"](
                        T["geometry_msgs/msg/Point"](0, 0, 0), T["geometry_msgs/msg/Quaternion"](0, 0, 0, 1))
                    odometry = T["nav_msgs/msg/Odometry"](
                        header, "base_link", T["geometry_msgs/msg/PoseWithCovariance"](pose, numpy.zeros(36)),
                        T["geometry_msgs/msg/TwistWithCovariance"](turned, numpy.zeros(36)))
                    _, unit_header = stamp(t_s + late_s - 0.001)
                    imu = T["sensor_msgs/msg/Imu"](
                        unit_header, T["geometry_msgs/msg/Quaternion"](0, 0, 0, 1), numpy.zeros(9),
                        vector(z=row["yaw_rate_rps"]), numpy.zeros(9), vector(z=9.81), numpy.zeros(9))
                    send("/imu", imu.__msgtype__, t_s + late_s - 0.001, imu)
                    send("/odom", odometry.__msgtype__, t_s + late_s, odometry)
            _, header = stamp(t_s)
            picture = pixels(drive / "frames" / f"{i:06}.ppm")
            height, width, _ = picture.shape
            bgr = numpy.ascontiguousarray(picture[:, :, ::-1]).ravel()
            raw = T["sensor_msgs/msg/Image"](header, height, width, "bgr8", 0, 3 * width, bgr)
            send("/front/image_raw", raw.__msgtype__, t_s, raw)
            info = camera_info(header, camera)
            send("/front/camera_info", info.__msgtype__, t_s, info)
            if kind == "packed":
                packed = T["sensor_msgs/msg/CompressedImage"](
                    header, "png", numpy.frombuffer(png(picture), numpy.uint8))
                send("/front/compressed", packed.__msgtype__, t_s, packed)


def convert(program, bag, out, mount, *more):
    command = [program, "convert", "bag", bag, "--mount", mount, "--out", out, "--json", *more]
    return subprocess.run([str(word) for word in command], capture_output=True, text=True)


def run(program, drive, camera, out):
    command = [program, "run", drive, "--camera", camera, "--no-recording", "--out", out]
    subprocess.run([str(word) for word in command], check=True, capture_output=True)
    records = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
    for record in records:
        del record["stage_ms"]
    return records


def compare_logs(out, truth):
    gps = [point for point in xml.etree.ElementTree.parse(out / "gps.gpx").iter() if point.tag.endswith("trkpt")]
    # The positions before the first picture are left out, and the one without a fix.
    expected = [(row["t_s"] + GPS_LATE_S, row) for i, row in enumerate(truth) if row["t_s"] + GPS_LATE_S >= 0 and i != 5]
    assert len(gps) == len(expected), f"{len(gps)} positions in place of {len(expected)}"
    for point, (t_s, row) in zip(gps, expected):
        assert abs(float(point.get("lat")) - row["lat"]) < 1e-6 and abs(float(point.get("lon")) - row["lon"]) < 1e-6
        assert point[0].text == f"1970-01-01T00:00:{t_s:06.3f}Z", f"{point[0].text} in place of {t_s} s"
    rows = [[float(number) for number in line.split(",")] for line in (out / "motion.csv").read_text().splitlines()[1:]]
    expected = [row for row in truth if row["t_s"] + TWIST_LATE_S <= truth[-1]["t_s"]]
    assert len(rows) == len(expected)
    for (t_s, speed, yaw_rate), row in zip(rows, expected):
        wanted = (row["t_s"] + TWIST_LATE_S, row["speed_mps"], row["yaw_rate_rps"])
        assert math.dist((t_s, speed, yaw_rate), wanted) < 2e-6, f"{(t_s, speed, yaw_rate)} in place of {wanted}"


def main(program, drive, work):
    truth = [json.loads(line) for line in (drive / "truth.jsonl").read_text().splitlines()]
    camera = tomllib.loads((drive / "camera.toml").read_text())
    work.mkdir()
    mount = work / "mount.toml"
    mount.write_text("[mount]\n" + "".join(f"{key} = {value}\n" for key, value in camera["mount"].items()))
    reference = run(program, drive, drive / "camera.toml", work / "reference")
    for kind in ("raw", "packed"):
        bag, out = work / f"bag_{kind}", work / f"drive_{kind}"
        write_bag(bag, drive, truth, camera, kind)
        if kind == "packed":
            asked = convert(program, bag, out, mount)
            assert asked.returncode == 1 and "--image-topic" in asked.stderr and "/front/image_raw" in asked.stderr, asked
        chosen = ["--image-topic", "/front/compressed"] if kind == "packed" else []
        done = convert(program, bag, out, mount, *chosen)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["frames"] == len(truth), done.stdout
        written = tomllib.loads((out / "camera.toml").read_text())
        assert all(abs(written["mount"][key] - value) < 1e-9 for key, value in camera["mount"].items())
        assert {key: written[key] for key in ("image", "intrinsics", "distortion")} == {
            key: camera[key] for key in ("image", "intrinsics", "distortion")}, "the camera differs"
        compare_logs(out, truth)
        records = run(program, out, out / "camera.toml", work / f"run_{kind}")
        assert records == reference, f"the converted drive ({kind}) runs otherwise than the drive"
    print(f"{len(truth)} frames of two bags convert, and run as the drive they were made of")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*(pathlib.Path(argument).resolve() for argument in sys.argv[1:]))
