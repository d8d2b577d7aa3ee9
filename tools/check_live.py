#!/usr/bin/env python3
"""Connects to `fingerpost run --serve foxglove` with somebody else's WebSocket client, and holds what it gets against frames.jsonl.

    tools/check_live.py FINGERPOST DRIVE OUT

FINGERPOST is the program, DRIVE a folder of `simulate`, OUT a run folder to write. Needs the packages websockets, mcap and
mcap-protobuf-support, whose decoder reads the schemas as they are advertised.
"""
import asyncio
import base64
import json
import pathlib
import struct
import subprocess
import sys
from collections import Counter

import websockets
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory


async def address(process):
    """Where the program says that viewers may connect."""
    while line := await process.stderr.readline():
        words = line.decode().split()
        if words[:2] == ["viewers", "may"]:
            return words[-1]
    raise AssertionError("the program does not say where to connect")


async def view(url, messages):
    """Subscribes to every channel and collects what comes until the server ends it."""
    async with websockets.connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
        info, advertised = json.loads(await socket.recv()), json.loads(await socket.recv())
        assert info["op"] == "serverInfo" and info["name"].startswith("fingerpost"), info
        assert advertised["op"] == "advertise"
        channels = {channel["id"]: channel for channel in advertised["channels"]}
        wishes = [{"id": 100 + id, "channelId": id} for id in channels]
        await socket.send(json.dumps({"op": "subscribe", "subscriptions": wishes}))
        async for message in socket:
            kind, subscription, time_ns = struct.unpack_from("<BIQ", message)
            assert kind == 1, f"an unknown message {kind}"
            messages.append((channels[subscription - 100], time_ns, message[13:]))


async def answer(url, host, subprotocol, origin):
    """The status that a handshake under this name, for this protocol and from a page of this site is answered with."""
    at, port = url.removeprefix("ws://").split(":")
    reader, writer = await asyncio.open_connection(at, int(port))
    writer.write(
        f"GET / HTTP/1.1\r\nHost: {host.format(port=port)}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {subprotocol}\r\n"
        f"Origin: {origin}\r\n\r\n".encode())
    status = int((await reader.readline()).split()[1])
    writer.close()
    return status


async def main(program, drive, out):
    command = [program, "run", drive, "--camera", drive / "camera.toml", "--route", drive / "route.geojson", "--start-m", "0",
               "--no-recording", "--serve", "foxglove", "--serve-port", "0", "--out", out]
    process = await asyncio.create_subprocess_exec(*map(str, command), stderr=asyncio.subprocess.PIPE)
    url = await address(process)
    messages, others = [], []
    viewers = asyncio.gather(view(url, messages), view(url, others))
    app, this, other = "https://app.foxglove.dev", "http://localhost:8080", "https://example.org"
    for host, subprotocol, origin, status in [
        ("127.0.0.1:{port}", "mqtt", app, 400), ("example.org:{port}", "foxglove.sdk.v1", app, 403),
        ("127.0.0.1:{port}", "foxglove.sdk.v1", other, 403), ("localhost:{port}", "foxglove.websocket.v1", this, 101),
    ]:
        assert await answer(url, host, subprotocol, origin) == status, (host, subprotocol, origin)
    said = process.stderr.read()
    await viewers
    await said
    assert await process.wait() == 0
    records = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
    counts = Counter()
    for channel, time_ns, data in messages:
        counts[channel["topic"]] += 1
        if channel["encoding"] == "json":
            record = json.loads(data)
            assert record == records[record["frame"]], f"frame {record['frame']} differs from frames.jsonl"
            assert abs(time_ns / 1e9 - record["t_s"]) < 1e-6
            continue
        schema = Schema(id=1, name=channel["schemaName"], encoding="protobuf", data=base64.b64decode(channel["schema"]))
        decoded = DecoderFactory().decoder_for("protobuf", schema)(data)
        if channel["topic"] in ("/camera/image", "/ground_view/image"):
            assert decoded.data[:2] == b"\xff\xd8" and decoded.format == "jpeg"
        if channel["topic"] == "/route":
            assert json.loads(decoded.geojson)["type"] == "FeatureCollection"
    # Viewers come while the first frames go by, and the last frame is waited for.
    assert counts["/record"] >= len(records) // 2 and counts["/route"] == 1, counts
    last = [json.loads(data)["frame"] for channel, _, data in messages if channel["topic"] == "/record"][-1]
    assert last == len(records) - 1, f"the last frame that came is {last} of {len(records)}"
    for topic in ("/camera/image", "/ground_view/image", "/road_surface", "/odometry", "/tf", "/lanes", "/driving_line"):
        assert counts[topic] == counts["/record"], f"{topic}: {counts[topic]} of {counts['/record']}"
    assert len(others) > len(messages) // 2, "a second viewer got less"
    print(f"{len(messages)} messages of {len(counts)} topics from {counts['/record']} of {len(records)} frames came")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    asyncio.run(main(*(pathlib.Path(argument).resolve() for argument in sys.argv[1:])))
