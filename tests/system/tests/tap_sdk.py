"""Closes a finger through ROBOTIS' own SDK, reading the servo's position in every way there is, in turn.

Usage: tap_sdk.py PORT BAUD_RATE SERVO GOAL
"""

import itertools
import sys
import time

import dynamixel_sdk as sdk
from sdk_port import packets, port

SERVO, GOAL = int(sys.argv[3]), int(sys.argv[4])
sync = sdk.GroupSyncRead(port, packets, 132, 4)
assert sync.addParam(SERVO)
bulk = sdk.GroupBulkRead(port, packets)
assert bulk.addParam(SERVO, 132, 4)


def alone():
    position, communication, _ = packets.read4ByteTxRx(port, SERVO, 132)
    return position if communication == sdk.COMM_SUCCESS else None


def grouped(group, read):
    return group.getData(SERVO, 132, 4) if read() == sdk.COMM_SUCCESS else None


WAYS = [
    alone,
    lambda: grouped(sync, sync.txRxPacket),
    lambda: grouped(sync, sync.fastSyncRead),
    lambda: grouped(bulk, bulk.txRxPacket),
    lambda: grouped(bulk, bulk.fastBulkRead),
]


def write(size, address, value):
    for _ in range(10):
        write = packets.write4ByteTxRx if size == 4 else packets.write1ByteTxRx
        if write(port, SERVO, address, value)[0] == sdk.COMM_SUCCESS:
            return
        time.sleep(0.2)
        port.ser.reset_input_buffer()
    raise AssertionError("the servo does not answer")


# The simulated servo's time passes by reads: slow enough for many positions on the way.
write(4, 112, 10)
write(1, 64, 1)
write(4, 116, GOAL)
arrived = set()
deadline = time.monotonic() + 100
shown = time.monotonic()
for number, way in itertools.cycle(enumerate(WAYS)):
    if way() == GOAL:
        arrived.add(number)
    # Until every way has shown it: then each of them works. And on for a while, so that a listener on a busy PC is done as well.
    if len(arrived) < len(WAYS):
        shown = time.monotonic()
    elif time.monotonic() > shown + 5:
        break
    # So that a listener on a busy PC keeps up.
    time.sleep(0.01)
    assert time.monotonic() < deadline, f"the servo does not arrive: {arrived}"
port.closePort()
