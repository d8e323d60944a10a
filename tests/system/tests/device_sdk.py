"""Reads a finger's force from the gripper, a device beside the servo on one bus, through ROBOTIS' own SDK.

Usage: device_sdk.py PORT BAUD_RATE SERVO GRIPPER GOAL

Leads the servo, as any program of its owner does, and asks the gripper. Prints what it learns, one fact per line.
"""

import struct
import sys
import time

import dynamixel_sdk as sdk
from sdk_port import packets, port

SERVO, GRIPPER, GOAL = (int(word) for word in sys.argv[3:6])
NOBODY = 77
BLOCK = 128  # of the first finger: its results are 40 bytes


def say(name, *facts):
    print(name, *facts, flush=True)


def patient(call):
    """What the SDK says once it has got an answer: it waits half a second for one, which a very busy machine can exceed."""
    for _ in range(10):
        *value, communication, error = call()
        if communication == sdk.COMM_SUCCESS:
            return value[0] if value else None, error
        time.sleep(0.2)
        port.ser.reset_input_buffer()
    raise AssertionError(packets.getTxRxResult(communication))


def group(call):
    for _ in range(10):
        result = call()
        if result == sdk.COMM_SUCCESS:
            return
        time.sleep(0.2)
        port.ser.reset_input_buffer()
    raise AssertionError(packets.getTxRxResult(result))


def go(goal):
    patient(lambda: packets.write4ByteTxRx(port, SERVO, 116, goal))
    deadline = time.monotonic() + 60
    while patient(lambda: packets.read4ByteTxRx(port, SERVO, 132))[0] != goal:
        assert time.monotonic() < deadline, "the servo does not arrive"


TRACKING = 1


def results():
    """The finger's results, once they belong to the servo's present position, which the gripper hears us read, and have converged: a
    tick that is short of time is `tracking`, and the next ones of a finger that stands still go on from there."""
    deadline = time.monotonic() + 20
    while True:
        position = patient(lambda: packets.read4ByteTxRx(port, SERVO, 132))[0]
        block, error = patient(lambda: packets.readTxRx(port, GRIPPER, BLOCK, 40))
        assert error == 0, packets.getRxPacketError(error)
        x, y, size, cx, cy, torque, status, sound, _, age, angle, at = struct.unpack("<iiIiiiBBhIii", bytes(block))
        if at == position and sound and status != TRACKING:
            return x, y, size, cx, cy, torque, status, angle, at
        assert time.monotonic() < deadline, f"no force at {position}: status {status}, position {at}"


def settle():
    """Lets late answers to questions that were repeated pass."""
    time.sleep(1)
    port.ser.reset_input_buffer()


def raw(sent, expected, seconds=5):
    """Sends bytes as they are; gives what comes, up to so many bytes."""
    settle()
    port.writePort(sent)
    answer = b""
    deadline = time.monotonic() + seconds
    while len(answer) < expected and time.monotonic() < deadline:
        answer += bytes(port.readPort(expected - len(answer)))
    time.sleep(0.05)
    return (answer + bytes(port.readPort(64))).hex()


def packet(identity, *body, damage=0):
    length = len(body) + 2
    head = [0xFF, 0xFF, 0xFD, 0, identity, length & 255, length >> 8, *body]
    crc = packets.updateCRC(0, head, len(head)) ^ damage
    return bytes([*head, crc & 255, crc >> 8])


say("ping", *patient(lambda: packets.ping(port, GRIPPER)))
say("servo", *patient(lambda: packets.ping(port, SERVO)))
say("baud", *patient(lambda: packets.read1ByteTxRx(port, GRIPPER, 8)))
# The object: a circle of 40 mm at (41, 45) mm.
for offset, number in ((68, 41000), (72, 45000), (76, 40000)):
    say("object", *patient(lambda: packets.write4ByteTxRx(port, GRIPPER, BLOCK + offset, number)))
patient(lambda: packets.write4ByteTxRx(port, SERVO, 112, 60))
patient(lambda: packets.write1ByteTxRx(port, SERVO, 64, 1))
start = patient(lambda: packets.read4ByteTxRx(port, SERVO, 132))[0]
say("open", *results())
go(GOAL)
say("closed", *results())
settle()

# The servo and the gripper in one question each way round, plain and fast: position, and force y.
for order in ((SERVO, GRIPPER), (GRIPPER, SERVO)):
    sync = sdk.GroupSyncRead(port, packets, 132, 4)
    assert all(sync.addParam(identity) for identity in order)
    for name, read in (("sync", sync.txRxPacket), ("fast-sync", sync.fastSyncRead)):
        group(read)
        say(name, sync.getData(SERVO, 132, 4), sync.getData(GRIPPER, 132, 4))
    bulk = sdk.GroupBulkRead(port, packets)
    assert all(bulk.addParam(identity, *((132, 4) if identity == SERVO else (136, 4))) for identity in order)
    for name, read in (("bulk", bulk.txRxPacket), ("fast-bulk", bulk.fastBulkRead)):
        group(read)
        say(name, bulk.getData(SERVO, 132, 4), bulk.getData(GRIPPER, 136, 4))

settle()
say("nobody", *packets.ping(port, NOBODY))
say("access", *patient(lambda: packets.write4ByteTxRx(port, GRIPPER, BLOCK, 1)))
say("range", *patient(lambda: packets.write1ByteTxRx(port, GRIPPER, 8, 8)))
say("delay-range", *patient(lambda: packets.write1ByteTxRx(port, GRIPPER, 9, 1)))
say("limit", *patient(lambda: packets.write1ByteTxRx(port, GRIPPER, 7, SERVO)))
say("length", *patient(lambda: packets.write2ByteTxRx(port, GRIPPER, BLOCK + 68, 1)))
say("crc", raw(packet(GRIPPER, 0x02, 8, 0, 1, 0, damage=0x10), 11))
# A write that nobody answers, and a question right behind it; then two questions at once.
quiet = packet(254, 0x83, 68, 0, 1, 0, GRIPPER, 1)
say("back-to-back", raw(quiet + packet(GRIPPER, 0x02, 68, 0, 1, 0), 12))
say("quiet", raw(packet(GRIPPER, 0x03, 68, 0, 2), 1, 0.5))
ping = packet(GRIPPER, 0x01)
say("twice", raw(ping + ping, 28))
say("reg-write", *patient(lambda: packets.regWriteTxRx(port, GRIPPER, 9, 1, [200])))
say("action", raw(packet(GRIPPER, 0x05), 11))
say("delay", *patient(lambda: packets.read1ByteTxRx(port, GRIPPER, 9)))
go(start)
say("opened", *results())

# Another address, another zero, another rate; a restart forgets none of them.
patient(lambda: packets.write4ByteTxRx(port, GRIPPER, BLOCK + 48, 204850))
patient(lambda: packets.write1ByteTxRx(port, GRIPPER, 7, GRIPPER + 1))
settle()
say("moved", *packets.ping(port, GRIPPER))
say("renamed", *patient(lambda: packets.ping(port, GRIPPER + 1)))
patient(lambda: packets.write1ByteTxRx(port, GRIPPER + 1, 8, 1))
patient(lambda: packets.reboot(port, GRIPPER + 1))
say("restarted", *patient(lambda: packets.ping(port, GRIPPER + 1)))
say("rate", *patient(lambda: packets.read1ByteTxRx(port, GRIPPER + 1, 8)))
say("zero", *patient(lambda: packets.read4ByteTxRx(port, GRIPPER + 1, BLOCK + 48)))
port.closePort()
