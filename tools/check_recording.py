#!/usr/bin/env python3
"""Reads a run's run.mcap with a reader that others wrote, and compares it with the frames.jsonl beside it.

    tools/check_recording.py RUN_FOLDER

Every message of every schema is decoded. Needs the packages mcap and mcap-protobuf-support.
"""
import json
import pathlib
import sys
from collections import Counter

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

# Topics with a message in every frame that was used.
EVERY_FRAME = [
    "/camera/image", "/camera/calibration", "/camera/annotations", "/ground_view/image", "/road_surface", "/feature",
    "/driving_line", "/driving_line/poses", "/centreline", "/lanes", "/odometry", "/tf",
]


def main(run):
    records = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    used = [record for record in records if "error" not in record or record["error"] is None]
    counts, schemas = Counter(), set()
    with open(run / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for schema, channel, message in reader.iter_messages():
            counts[channel.topic] += 1
            schemas.add(schema.name)
            time_s = message.log_time / 1e9
            if channel.topic == "/record":
                record = json.loads(message.data)
                assert record == records[message.sequence], f"frame {message.sequence} differs from frames.jsonl"
                assert abs(time_s - max(0.0, record["t_s"])) < 1e-6, f"frame {message.sequence} has another time"
                continue
            decoded = DecoderFactory().decoder_for(channel.message_encoding, schema)(message.data)
            if channel.topic == "/camera/image":
                assert decoded.data[:2] == b"\xff\xd8" and decoded.format == "jpeg", "the picture is no JPEG"
            if channel.topic == "/road_surface":
                rows, rest = divmod(len(decoded.data), decoded.row_stride)
                assert rows > 0 and rest == 0, "the road surface is no grid"
            if channel.topic == "/odometry":
                assert all(decoded.pose_covariance[axis * 7] > 0.0 for axis in (2, 3, 4)), "a covariance is zero"
                norm = sum(getattr(decoded.pose.orientation, axis) ** 2 for axis in "xyzw")
                assert abs(norm - 1.0) < 1e-6, "an orientation is no rotation"
    assert counts["/record"] == len(records), f"{counts['/record']} records of {len(records)} frames"
    for topic in EVERY_FRAME:
        assert counts[topic] == len(used), f"{topic}: {counts[topic]} messages of {len(used)} frames"
    print(f"{sum(counts.values())} messages of {len(counts)} topics and {len(schemas)} schemas")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
