#!/usr/bin/env python3
"""Decodes random CAN frames with cantools, for the tests of fingerpost-io.

    pip install cantools
    python tools/golden/cantools_golden.py crates/fingerpost-io/tests/can/signals.dbc > crates/fingerpost-io/tests/can/cantools.csv

A line is FRAME,SIGNAL,VALUE: a frame as candump writes it, a signal that it holds, and the signal's scaled value.
"""
import math
import random
import struct
import sys

import cantools

random.seed(5)
database = cantools.database.load_file(sys.argv[1])


def decode(name, data):
    message = database.get_message_by_name(name)
    digits = 8 if message.is_extended_frame else 3
    frame = f"{message.frame_id:0{digits}X}#{data.hex().upper()}"
    for signal, value in message.decode(data, decode_choices=False).items():
        print(f"{frame},{name}.{signal},{float(value)!r}")


print("frame,signal,value")
for _ in range(4):
    decode("KINEMATICS", random.randbytes(8))
    for name in ("BLINKERS_STATE", "WIDE", "WIDE_BACKWARDS", "ACROSS"):
        decode(name, random.randbytes(8))
    data = random.randbytes(8)
    while not math.isfinite(struct.unpack("<f", data[4:])[0]):
        data = random.randbytes(8)
    decode("WHEELS", data)
# Pages of the multiplexed message: 1, 5 and 6 show one signal, 2 another that selects a third.
for first in (0x01, 0x35, 0x06):
    decode("BODY", bytes([first]) + random.randbytes(3))
for second in (0x53, 0xF4):
    decode("BODY", bytes([0x02, second]) + random.randbytes(2))
