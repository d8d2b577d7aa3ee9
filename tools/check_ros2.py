#!/usr/bin/env python3
"""Drives `fingerpost ros2` through somebody else's DDS, and holds what it sends against `fingerpost run` on the same pictures.

    tools/check_ros2.py FINGERPOST DRIVE MAP OUT

FINGERPOST is the program, built with the feature ros2, DRIVE a folder of `simulate` on the MAP along a route, OUT a new folder to work in.
Needs the packages cyclonedds, pillow, mcap and mcap-protobuf-support. Both sides speak over the loopback interface alone, without multicast.

First every picture of the drive is sent packed at the drive's pace, and every result is expected: none is lost, frames are named as REP 105
names them, no variance is zero, poses and commands are those of `run`, and the last command is to stop. Then bare pictures of several encodings and the calibration as a message,
with broken pictures in between: each of these is reported and ends nothing, and silence commands the vehicle to stop. At last GPS and twist
beside the pictures, on the map. How long results take is printed and held against nothing: machines that check are busy with other things.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import tomllib
import types
from collections import defaultdict
from dataclasses import dataclass

os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain id="any"><General><AllowMulticast>false</AllowMulticast>
<Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, sequence, uint8, uint16, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from PIL import Image as Pillow

# A domain that nobody else on this machine is likely to be in.
DOMAIN = 97
# When the made-up drive takes place, nanoseconds since 1970; no multiple of anything.
BEGAN_NS = 1_700_000_123_456_789_123
# Longest time that something is waited for, seconds.
PATIENCE_S = 20.0
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5), Policy.Durability.Volatile)
RESULT = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepAll, Policy.Durability.Volatile)


def ros(package):
    """A message of ROS 2, named as its middleware names it."""
    def of(name, /, **fields):
        keywords = {"typename": f"{package}::msg::dds_::{name}_"}
        body = {"__annotations__": fields, "__module__": __name__}
        return dataclass(types.new_class(name, (IdlStruct,), keywords, lambda namespace: namespace.update(body)))
    return of


std, geometry, sensor, nav = ros("std_msgs"), ros("geometry_msgs"), ros("sensor_msgs"), ros("nav_msgs")
Time = ros("builtin_interfaces")("Time", sec=int32, nanosec=uint32)
Duration = ros("builtin_interfaces")("Duration", sec=int32, nanosec=uint32)
Header = std("Header", stamp=Time, frame_id=str)
Image = sensor("Image", header=Header, height=uint32, width=uint32, encoding=str, is_bigendian=uint8, step=uint32, data=sequence[uint8])
CompressedImage = sensor("CompressedImage", header=Header, format=str, data=sequence[uint8])
Region = sensor("RegionOfInterest", x_offset=uint32, y_offset=uint32, height=uint32, width=uint32, do_rectify=bool)
CameraInfo = sensor("CameraInfo", header=Header, height=uint32, width=uint32, distortion_model=str, d=sequence[float64], k=array[float64, 9],
                    r=array[float64, 9], p=array[float64, 12], binning_x=uint32, binning_y=uint32, roi=Region)
NavSatStatus = sensor("NavSatStatus", status=int8, service=uint16)
NavSatFix = sensor("NavSatFix", header=Header, status=NavSatStatus, latitude=float64, longitude=float64, altitude=float64,
                   position_covariance=array[float64, 9], position_covariance_type=uint8)
Vector3 = geometry("Vector3", x=float64, y=float64, z=float64)
Point = geometry("Point", x=float64, y=float64, z=float64)
Quaternion = geometry("Quaternion", x=float64, y=float64, z=float64, w=float64)
Pose = geometry("Pose", position=Point, orientation=Quaternion)
PoseStamped = geometry("PoseStamped", header=Header, pose=Pose)
PoseWithCovariance = geometry("PoseWithCovariance", pose=Pose, covariance=array[float64, 36])
Twist = geometry("Twist", linear=Vector3, angular=Vector3)
TwistStamped = geometry("TwistStamped", header=Header, twist=Twist)
TwistWithCovariance = geometry("TwistWithCovariance", twist=Twist, covariance=array[float64, 36])
Transform = geometry("Transform", translation=Vector3, rotation=Quaternion)
TransformStamped = geometry("TransformStamped", header=Header, child_frame_id=str, transform=Transform)
TFMessage = ros("tf2_msgs")("TFMessage", transforms=sequence[TransformStamped])
Odometry = nav("Odometry", header=Header, child_frame_id=str, pose=PoseWithCovariance, twist=TwistWithCovariance)
Path = nav("Path", header=Header, poses=sequence[PoseStamped])
AckermannDrive = ros("ackermann_msgs")("AckermannDrive", steering_angle=float32, steering_angle_velocity=float32, speed=float32,
                                      acceleration=float32, jerk=float32)
AckermannDriveStamped = ros("ackermann_msgs")("AckermannDriveStamped", header=Header, drive=AckermannDrive)
KeyValue = ros("diagnostic_msgs")("KeyValue", key=str, value=str)
DiagnosticStatus = ros("diagnostic_msgs")("DiagnosticStatus", level=uint8, name=str, message=str, hardware_id=str, values=sequence[KeyValue])
DiagnosticArray = ros("diagnostic_msgs")("DiagnosticArray", header=Header, status=sequence[DiagnosticStatus])
Colour = std("ColorRGBA", r=float32, g=float32, b=float32, a=float32)
UV = ros("visualization_msgs")("UVCoordinate", u=float32, v=float32)
MeshFile = ros("visualization_msgs")("MeshFile", filename=str, data=sequence[uint8])
Marker = ros("visualization_msgs")(
    "Marker", header=Header, ns=str, id=int32, type=int32, action=int32, pose=Pose, scale=Vector3, color=Colour, lifetime=Duration,
    frame_locked=bool, points=sequence[Point], colors=sequence[Colour], texture_resource=str, texture=CompressedImage,
    uv_coordinates=sequence[UV], text=str, mesh_resource=str, mesh_file=MeshFile, mesh_use_embedded_materials=bool)
MarkerArray = ros("visualization_msgs")("MarkerArray", markers=sequence[Marker])

SENT = {"/fingerpost/odometry": Odometry, "/fingerpost/path": Path, "/fingerpost/driving_line": Path, "/fingerpost/feature": MarkerArray,
        "/fingerpost/ackermann_cmd": AckermannDriveStamped, "/fingerpost/fix": NavSatFix, "/diagnostics": DiagnosticArray, "/tf": TFMessage}
participant = DomainParticipant(DOMAIN)
# Programs that were started.
RUNNING = []


def header(ns, frame="camera"):
    return Header(Time(ns // 10**9, ns % 10**9), frame)


def stamp_ns(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def until(what, condition):
    """Waits until something is so."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, f"{what} did not come in {PATIENCE_S:.0f} s"
        time.sleep(0.005)


class Node:
    """The program with all that it sends."""

    def __init__(self, program, arguments, topics, log):
        """`topics` are those that it listens to, with their types."""
        self.writers = {name: DataWriter(participant, Topic(participant, f"rt{name}", kind), SENSOR) for name, kind in topics.items()}
        self.readers = {name: DataReader(participant, Topic(participant, f"rt{name}", kind), RESULT) for name, kind in SENT.items()}
        self.got, self.came = defaultdict(list), {}
        self.log = log
        self.errors = log.open("w")
        self.process = subprocess.Popen(
            [program, "ros2", "--domain", str(DOMAIN), "--interface", "127.0.0.1", "--tf", *map(str, arguments)],
            stdout=subprocess.DEVNULL, stderr=self.errors)
        RUNNING.append(self.process)
        until("the program's topics", lambda: self.process.poll() is not None or (
            all(writer.get_matched_subscriptions() for writer in self.writers.values())
            and all(reader.get_matched_publications() for reader in self.readers.values())))
        assert self.process.poll() is None, log.read_text()

    def take(self):
        """Takes what has come."""
        for name, reader in self.readers.items():
            # A writer that leaves is a sample without a message.
            for message in (sample for sample in reader.take(N=1000) if isinstance(sample, SENT[name])):
                self.got[name].append(message)
                if name == "/fingerpost/odometry":
                    self.came[stamp_ns(message.header)] = time.monotonic()

    def send(self, topic, message):
        self.writers[topic].write(message)

    def listen(self, until_s):
        while time.monotonic() < until_s:
            self.take()
            time.sleep(0.001)

    def wait_for(self, topic, count):
        def come():
            self.take()
            return len(self.got[topic]) >= count or self.process.poll() is not None
        until(f"message {count} of {topic} (after {len(self.got[topic])})", come)

    def end(self, how=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(how)
        code = self.process.wait(PATIENCE_S)
        self.take()
        self.errors.close()
        assert code == 0, (code, self.log.read_text())

    def commands(self):
        """Steering angle and speed that were commanded last at a picture's time, or at that of a stop, nanoseconds."""
        return {stamp_ns(message.header): (message.drive.steering_angle, message.drive.speed)
                for message in self.got["/fingerpost/ackermann_cmd"]}

    def said(self, part):
        """Levels and messages of the diagnostics of a part, in their order."""
        return [(status.level, status.message) for array in self.got["/diagnostics"] for status in array.status
                if status.name == f"fingerpost: {part}"]


def command(program, *arguments):
    subprocess.run([program, *map(str, arguments)], check=True, stderr=subprocess.DEVNULL)


def records(run):
    return [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]


def poses_of_recording(path):
    """Poses of `run` as (x, y, z, w of the quaternion), frame by frame."""
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        poses = [message.pose for *_, message in reader.iter_decoded_messages(topics=["/odometry"])]
    return [(pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w) for pose in poses]


def check_odometry(odometry, stamps_ns, expected):
    assert [stamp_ns(message.header) for message in odometry] == stamps_ns, "an odometry is missing, twice there or out of order"
    worst = 0.0
    for message, wanted in zip(odometry, expected, strict=True):
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
        for covariance in (message.pose.covariance, message.twist.covariance):
            assert all(covariance[axis * 7] > 0 for axis in range(6)), covariance
        at, turn = message.pose.pose.position, message.pose.pose.orientation
        worst = max(worst, *(abs(a - b) for a, b in zip((at.x, at.y, turn.z, turn.w), wanted, strict=True)))
    assert worst < 1e-6, f"a pose lies {worst} from that of run"


def check_commands(node, stamps_ns, expected):
    """Each picture's command is its advice; between them, where a picture is long in coming, and at the end is one to stop."""
    messages = node.got["/fingerpost/ackermann_cmd"]
    commands = node.commands()
    for ns, record in zip(stamps_ns, expected, strict=True):
        advice = record["advice"]
        angle, speed = commands.pop(ns)
        assert abs(angle - advice["steer_rad"]) < 1e-5 and abs(speed - advice["speed_mps"]) < 1e-3, (ns, angle, speed, advice)
        assert speed == 0 or (advice["line"] and not advice.get("stop")), (speed, advice)
    assert all(speed == 0 for _, speed in commands.values()), commands
    assert {message.header.frame_id for message in messages} == {"base_link"}
    assert not any(m.drive.steering_angle_velocity or m.drive.acceleration or m.drive.jerk for m in messages)
    last = messages[-1]
    assert stamp_ns(last.header) > stamps_ns[-1] and last.drive.speed == 0, last


def check_whole_drive(program, drive, out):
    """All pictures, packed, at the drive's pace."""
    route = ["--camera", drive / "camera.toml", "--route", drive / "route.geojson", "--start-m", "0"]
    command(program, "run", drive, *route, "--out", out / "run")
    expected, poses = records(out / "run"), poses_of_recording(out / "run/run.mcap")
    pictures = sorted((drive / "frames").glob("*.jpg"))
    times_s = [float(line) for line in (drive / "times.txt").read_text().split()]
    stamps_ns = [BEGAN_NS + round(t_s * 1e9) for t_s in times_s]
    node = Node(program, [*route, "--image-topic", "/camera/image_raw/compressed", "--out", out / "node", "--frames", len(pictures),
                          # A machine that is busy with other things may be late with all of them.
                          "--queue", len(pictures)],
                {"/camera/image_raw/compressed": CompressedImage}, out / "node.log")
    messages = [CompressedImage(header(ns), "jpeg", picture.read_bytes()) for ns, picture in zip(stamps_ns, pictures, strict=True)]
    began_s, sent_s = time.monotonic() + 0.1, {}
    for t_s, ns, message in zip(times_s, stamps_ns, messages):
        node.listen(began_s + t_s)
        sent_s[ns] = time.monotonic()
        node.send("/camera/image_raw/compressed", message)
    node.wait_for("/fingerpost/odometry", len(pictures))
    node.wait_for("/fingerpost/feature", len(pictures))
    node.end()

    check_odometry(node.got["/fingerpost/odometry"], stamps_ns, poses)
    check_commands(node, stamps_ns, expected)
    assert max(speed for _, speed in node.commands().values()) > 1, "the vehicle was never commanded to drive"
    got = records(out / "node")
    assert [record["frame"] for record in got] == list(range(len(pictures)))
    for record, wanted in zip(got, expected, strict=True):
        for key in ("state", "feature", "motion", "driving_line_m", "advice", "why"):
            assert record[key] == wanted[key], (record["frame"], key, record[key], wanted[key])
    summary = json.loads((out / "node/summary.json").read_text())
    assert not any(summary.get(key) for key in ("broken_frames", "dropped_frames", "interrupted")), summary

    paths = node.got["/fingerpost/path"]
    last = [(pose.pose.position.x, pose.pose.position.y) for pose in paths[-1].poses]
    assert len(paths) == len(last) > 10 and {path.header.frame_id for path in paths} == {"odom"}
    way = [pose[:2] for pose in poses]
    assert all(min(abs(x - a) + abs(y - b) for a, b in way) < 1e-6 for x, y in last), "the path leaves the odometry"
    for line, wanted in zip(node.got["/fingerpost/driving_line"], expected, strict=True):
        assert line.header.frame_id == "base_link" and len(line.poses) == max(len(wanted["driving_line_m"]) - 1, 0)
        for pose, (forward_m, left_m) in zip(line.poses, wanted["driving_line_m"]):
            assert abs(pose.pose.position.x - forward_m) + abs(pose.pose.position.y - left_m) < 1e-3
    followed = 0
    for array_, wanted in zip(node.got["/fingerpost/feature"], expected, strict=True):
        gone, *drawn = array_.markers
        texts = [marker.text for marker in drawn if marker.type == 9]
        assert gone.action == 3 and bool(wanted["feature"]) == bool(texts) and {m.header.frame_id for m in array_.markers} == {"base_link"}
        if wanted["feature"]:
            followed += 1
            assert texts[0].startswith(str(wanted["feature"]["id"])), texts
            node_at = next(marker.pose.position for marker in drawn if marker.type == 2)
            assert abs(node_at.x - wanted["feature"]["forward_m"]) + abs(node_at.y - wanted["feature"]["left_m"]) < 0.05
    assert followed > 10, f"features followed in {followed} frames"
    for transforms in node.got["/tf"]:
        assert [(t.header.frame_id, t.child_frame_id) for t in transforms.transforms] == [("odom", "base_link")]
    latencies_ms = sorted(1e3 * (node.came[ns] - sent_s[ns]) for ns in stamps_ns)
    p50, p95 = (latencies_ms[int(q * len(latencies_ms))] for q in (0.5, 0.95))
    print(f"{len(pictures)} pictures at {len(pictures) / times_s[-1]:.0f} Hz, none lost; features followed in {followed}; from picture sent to "
          f"odometry read: median {p50:.1f} ms, p95 {p95:.1f} ms, longest {latencies_ms[-1]:.1f} ms")


def bare(ns, encoding, picture):
    """A message of bare pixels, with padded rows."""
    bands = {"rgb8": "RGB", "bgr8": "BGR", "bgra8": "BGRA", "mono8": "L"}[encoding]
    if encoding == "mono8":
        packed = picture.convert("L").tobytes()
    elif encoding == "bgra8":
        red, green, blue = picture.split()
        packed = Pillow.merge("RGBA", (blue, green, red, red)).tobytes()
    else:
        packed = picture.tobytes("raw", bands)
    width, height = picture.size
    row = width * len(bands)
    rows = b"".join(packed[i * row:(i + 1) * row] + b"\xEE\xEE\xEE" for i in range(height))
    return Image(header(ns), height, width, encoding, 0, row + 3, rows)


def camera_info(ns, camera):
    k, size = camera["intrinsics"], camera["image"]
    projection = [k["fx"], 0, k["cx"], 0, 0, k["fy"], k["cy"], 0, 0, 0, 1, 0]
    return CameraInfo(header(ns), size["height"], size["width"], "plumb_bob", [0.0] * 5, [k["fx"], 0, k["cx"], 0, k["fy"], k["cy"], 0, 0, 1],
                      [1, 0, 0, 0, 1, 0, 0, 0, 1], projection, 0, 0, Region(0, 0, 0, 0, False))


def check_bare_pictures(program, drive, out):
    """Bare pictures of several encodings, broken ones among them, and the calibration as a message."""
    encodings = ["rgb8", "bgr8", "bgra8"] * 8 + ["mono8"] * 6
    files = sorted((drive / "frames").glob("*.jpg"))[:len(encodings)]
    times_s = [float(line) for line in (drive / "times.txt").read_text().split()][:len(encodings)]
    pictures = [Pillow.open(file).convert("RGB") for file in files]
    (out / "bare/frames").mkdir(parents=True)
    for i, (picture, encoding) in enumerate(zip(pictures, encodings)):
        same = picture.convert("L").convert("RGB") if encoding == "mono8" else picture
        same.save(out / f"bare/frames/{i:06}.png")
    (out / "bare/times.txt").write_text("".join(f"{t_s}\n" for t_s in times_s))
    command(program, "run", out / "bare", "--camera", drive / "camera.toml", "--out", out / "bare_run")
    poses = poses_of_recording(out / "bare_run/run.mcap")
    stamps_ns = [BEGAN_NS + round(t_s * 1e9) for t_s in times_s]

    camera = (drive / "camera.toml").read_text()
    (out / "mount.toml").write_text(camera[camera.index("[mount]"):])
    node = Node(program, ["--mount", out / "mount.toml"], {"/camera/image_raw": Image, "/camera/camera_info": CameraInfo},
                out / "bare.log")
    node.send("/camera/camera_info", camera_info(BEGAN_NS, tomllib.loads(camera)))
    # No picture is sent before the node has its calibration.
    until("the calibration", lambda: node.take() or any(level == 0 for level, _ in node.said("calibration")))
    used = 0

    def send(message, is_good=True):
        nonlocal used
        node.send("/camera/image_raw", message)
        used += is_good
        node.wait_for("/fingerpost/odometry", used)

    broken = 0
    last = len(pictures) - 1
    for i, (ns, encoding, picture) in enumerate(zip(stamps_ns, encodings, pictures)):
        if i == last:
            # Silence, which is said and ends nothing.
            until("the diagnostics of silence", lambda: node.take() or any(
                level == 3 and "silent" in message for level, message in node.said("pictures")))
            (stop_ns, (_, speed)) = max(node.commands().items())
            assert speed == 0 and stop_ns >= stamps_ns[i - 1] + 5 * 10**8, (stop_ns, speed)
        send(bare(ns, encoding, picture))
        if i in (10, 15, 20, 22, 24):
            bad = bare(ns + 1000, "rgb8", picture)
            if i == 10:
                bad.encoding, word = "yuv422", "yuv422"
            elif i == 15:
                bad.step, word = 1900, "rows of 1900 bytes"
            elif i == 20:
                bad.data, word = bad.data[:5000], "has 5000 bytes"
            elif i == 22:
                bad, word = bare(ns + 1000, "rgb8", picture.resize((320, 240))), "320 x 240"
            else:
                bad.header, word = header(0), "header.stamp"
            before = len(node.said("pictures"))
            send(bad, is_good=False)
            broken += 1

            def reported():
                node.take()
                return any(level == 1 and word in message for level, message in node.said("pictures")[before:])
            until(f"the diagnostics of {word}", reported)
    until("the end of the silence", lambda: "has come again" in node.log.read_text())
    node.end()
    check_odometry(node.got["/fingerpost/odometry"], stamps_ns, poses)
    check_commands(node, stamps_ns, records(out / "bare_run"))
    log = node.log.read_text()
    assert "has been silent for" in log and "the vehicle is commanded to stop" in log, log
    print(f"{used} bare pictures of {len(set(encodings))} encodings as run has them, {broken} broken ones and silence reported")


def check_gps_and_twist(program, drive, map_, out):
    """GPS and twist beside the pictures, on the map; ended by Ctrl-C with a run folder."""
    truth = [json.loads(line) for line in (drive / "truth.jsonl").read_text().splitlines()][:100]
    pictures = sorted((drive / "frames").glob("*.jpg"))[:len(truth)]
    near = f"{truth[0]['lat']},{truth[0]['lon']}"
    topics = {"/camera/image_raw/compressed": CompressedImage, "/gps/fix": NavSatFix, "/vehicle/twist": TwistStamped}
    node = Node(program, ["--camera", drive / "camera.toml", "--map", map_, "--near", near, "--image-topic", "/camera/image_raw/compressed",
                          "--gps-topic", "/gps/fix", "--twist-topic", "/vehicle/twist", "--no-recording", "--out", out / "sensed"],
                topics, out / "sensed.log")
    for i, (row, picture) in enumerate(zip(truth, pictures)):
        ns = BEGAN_NS + round(row["t_s"] * 1e9)
        twist = Twist(Vector3(row["speed_mps"], 0, 0), Vector3(0, 0, row["yaw_rate_rps"]))
        node.send("/vehicle/twist", TwistStamped(header(ns - 10**6, "base_link"), twist))
        if i % 20 == 0:
            status = NavSatStatus(0, 1)
            node.send("/gps/fix", NavSatFix(header(ns - 10**6, "gps"), status, row["lat"], row["lon"], 0, [4, 0, 0, 0, 4, 0, 0, 0, 9], 2))
        # Messages of different topics may overtake each other.
        node.listen(time.monotonic() + 0.01)
        node.send("/camera/image_raw/compressed", CompressedImage(header(ns), "jpeg", picture.read_bytes()))
        node.wait_for("/fingerpost/odometry", i + 1)
    node.wait_for("/fingerpost/fix", len(truth))
    node.end()
    got = records(out / "sensed")
    by_bus = sum(record["signals"]["source"].get("speed") == "can" for record in got)
    with_gps = sum(any(m["kind"] == "gps" for m in record["fix"].get("measurements", [])) for record in got)
    assert by_bus > 0.9 * len(got) and with_gps >= 4, (by_bus, with_gps)
    located = False
    for fix, transforms, record in zip(node.got["/fingerpost/fix"], node.got["/tf"], got, strict=True):
        is_one_place = record["fix"]["status"] in ("converged", "coasting")
        located |= is_one_place
        assert fix.header.frame_id == "base_link" and fix.status.status == (0 if is_one_place else -1)
        assert all(fix.position_covariance[axis * 4] > 0 for axis in range(3))
        assert abs(fix.latitude - record["fix"]["lat"]) + abs(fix.longitude - record["fix"]["lon"]) < 1e-6
        chain = [(t.header.frame_id, t.child_frame_id) for t in transforms.transforms]
        assert chain == [("map", "odom")] * located + [("odom", "base_link")], chain
    assert json.loads((out / "sensed/summary.json").read_text())["frames"] == len(truth) and (out / "sensed/report.html").exists()
    print(f"{len(truth)} pictures with GPS ({with_gps} positions) and twist (speed used in {by_bus}) on the map")


def main(program, drive, map_, out):
    out.mkdir(parents=True)
    try:
        check_whole_drive(program, drive, out)
        check_bare_pictures(program, drive, out)
        check_gps_and_twist(program, drive, map_, out)
    finally:
        for process in RUNNING:
            process.kill()


if __name__ == "__main__":
    main(sys.argv[1], *map(pathlib.Path, sys.argv[2:]))
