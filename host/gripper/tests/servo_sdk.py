"""Closes and opens a simulated finger through ROBOTIS' own SDK; prints position and current on the way.

Usage: servo_sdk.py PORT BAUD_RATE GOAL
"""

import sys
import time

import dynamixel_sdk as sdk
from dynamixel_sdk import port_handler

SERVO = 1
port_handler.LATENCY_TIMER = 2000  # ms, half of what an answer is waited for: a busy machine needs more than the SDK's 16
port = sdk.PortHandler(sys.argv[1])
packets = sdk.PacketHandler(2.0)
assert port.openPort(), "the port does not open"
assert port.setBaudRate(int(sys.argv[2])), "the port refuses the baud rate"


def done(call, *arguments):
    """The value, if the bus and the servo agree that there is one."""
    *value, communication, error = call(port, SERVO, *arguments)
    assert communication == sdk.COMM_SUCCESS, packets.getTxRxResult(communication)
    assert error == 0, packets.getRxPacketError(error)
    return value[0] if value else None


def go(goal):
    done(packets.write4ByteTxRx, 116, goal)
    deadline = time.monotonic() + 20
    while done(packets.read1ByteTxRx, 122):
        assert time.monotonic() < deadline, "the servo does not arrive"
    position = done(packets.read4ByteTxRx, 132)
    current = done(packets.read2ByteTxRx, 126)
    print("at", position, current - 65536 if current > 32767 else current, flush=True)


print("model", done(packets.ping), flush=True)
start = done(packets.read4ByteTxRx, 132)
print("start", start, flush=True)
done(packets.write4ByteTxRx, 112, 60)
done(packets.write4ByteTxRx, 108, 20)
done(packets.write1ByteTxRx, 64, 1)
try:
    done(packets.write1ByteTxRx, 9, 0)
except AssertionError as refused:
    print("eeprom", refused, flush=True)
go(int(sys.argv[3]))
go(start)
done(packets.write1ByteTxRx, 64, 0)
port.closePort()
