"""Talks to two simulated servos through ROBOTIS' own SDK and prints what it learns, one fact per line.

Usage: protocol_sdk.py PORT BAUD_RATE
"""

import sys
import time

import dynamixel_sdk as sdk
from dynamixel_sdk import port_handler

ONE, TWO, NOBODY = 1, 2, 77


def say(name, *facts):
    print(name, *facts, flush=True)


port_handler.LATENCY_TIMER = 2000  # ms, half of what an answer is waited for: a busy machine needs more than the SDK's 16
port = sdk.PortHandler(sys.argv[1])
packets = sdk.PacketHandler(2.0)
assert port.openPort(), "the port does not open"
assert port.setBaudRate(int(sys.argv[2])), "the port refuses the baud rate"

say("ping", *packets.ping(port, TWO))
say("read1", *packets.read1ByteTxRx(port, ONE, 146))
say("read2", *packets.read2ByteTxRx(port, ONE, 144))
say("read4", *packets.read4ByteTxRx(port, TWO, 132))
say("stuffed", *packets.read4ByteTxRx(port, ONE, 128))
say("write1", *packets.write1ByteTxRx(port, ONE, 65, 1))
say("write2", *packets.write2ByteTxRx(port, ONE, 38, 500))
say("write4", *packets.write4ByteTxRx(port, ONE, 116, 512))
# The SDK stuffs a copy of what it sends and then sends the original, so its stuffing is shown instead of sent.
body = [0x03, 76, 0, 255, 255, 253, 0, 255, 255, 255, 253]
say("stuffing", bytes(packets.addStuffing([255, 255, 253, 0, TWO, len(body) + 2, 0, *body, 0, 0])[:-2]).hex())

sync_read = sdk.GroupSyncRead(port, packets, 132, 4)
for servo in (TWO, ONE):
    assert sync_read.addParam(servo)
say("sync-read", sync_read.txRxPacket(), sync_read.getData(TWO, 132, 4), sync_read.getData(ONE, 132, 4))
say("fast-sync-read", sync_read.fastSyncRead(), sync_read.getData(TWO, 132, 4), sync_read.getData(ONE, 132, 4))

sync_write = sdk.GroupSyncWrite(port, packets, 108, 4)
assert sync_write.addParam(ONE, [150, 0, 0, 0])
assert sync_write.addParam(TWO, [170, 0, 0, 0])
say("sync-write", sync_write.txPacket())
say("sync-written", *packets.read4ByteTxRx(port, ONE, 108), *packets.read4ByteTxRx(port, TWO, 108))

bulk_read = sdk.GroupBulkRead(port, packets)
assert bulk_read.addParam(ONE, 144, 2)
assert bulk_read.addParam(TWO, 146, 1)
say("bulk-read", bulk_read.txRxPacket(), bulk_read.getData(ONE, 144, 2), bulk_read.getData(TWO, 146, 1))
say("fast-bulk-read", bulk_read.fastBulkRead(), bulk_read.getData(ONE, 144, 2), bulk_read.getData(TWO, 146, 1))

bulk_write = sdk.GroupBulkWrite(port, packets)
assert bulk_write.addParam(ONE, 112, 4, [7, 0, 0, 0])
assert bulk_write.addParam(TWO, 65, 1, [1])
say("bulk-write", bulk_write.txPacket())
say("bulk-written", *packets.read4ByteTxRx(port, ONE, 112), *packets.read1ByteTxRx(port, TWO, 65))

say("reg-write", *packets.regWriteTxRx(port, ONE, 102, 2, [44, 1]))
say("before-action", *packets.read2ByteTxRx(port, ONE, 102))
# The SDK leaves the answer to Action unread and would take it for that of the next instruction.
sent = packets.action(port, ONE)
answer = b""
deadline = time.monotonic() + 2
while len(answer) < 11 and time.monotonic() < deadline:
    answer += port.readPort(11 - len(answer))
say("action", sent, answer.hex())
say("after-action", *packets.read2ByteTxRx(port, ONE, 102))
say("reboot", *packets.reboot(port, TWO))
say("clear", *packets.clearMultiTurn(port, TWO))
say("factory-reset", *packets.factoryReset(port, TWO, 2))

say("nobody", *packets.ping(port, NOBODY))
say("access", *packets.write4ByteTxRx(port, ONE, 132, 0))
say("length", *packets.write2ByteTxRx(port, ONE, 116, 0))
say("range", *packets.write1ByteTxRx(port, ONE, 64, 9))
say("limit", *packets.write4ByteTxRx(port, ONE, 116, 9999))
found, result = packets.broadcastPing(port)
say("broadcast-ping", result, sorted(found.items()))
port.closePort()
