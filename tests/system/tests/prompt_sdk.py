"""Closes a finger step by step through ROBOTIS' own SDK, and asks the gripper right after each position of the servo.

Usage: prompt_sdk.py PORT BAUD_RATE SERVO GRIPPER GOAL

Prints the servo's position, and the position and its age in µs that the gripper has answered with.
"""

import sys
import time

import dynamixel_sdk as sdk
from dynamixel_sdk import port_handler

SERVO, GRIPPER, GOAL = (int(word) for word in sys.argv[3:6])
port_handler.LATENCY_TIMER = 250  # ms, half of what an answer is waited for: a busy machine needs more than the SDK's 16
port = sdk.PortHandler(sys.argv[1])
packets = sdk.PacketHandler(2.0)
assert port.openPort(), "the port does not open"
assert port.setBaudRate(int(sys.argv[2])), "the port refuses the baud rate"


def sound(answer):
    *data, communication, error = answer
    assert (communication, error) == (sdk.COMM_SUCCESS, 0), packets.getTxRxResult(communication)
    return data


sound(packets.write4ByteTxRx(port, SERVO, 112, 40))
sound(packets.write1ByteTxRx(port, SERVO, 64, 1))
sound(packets.write4ByteTxRx(port, SERVO, 116, GOAL))
position = 0
# Under load the last counts take long.
while position < GOAL - 5:
    # The gripper estimates once a period.
    time.sleep(0.05)
    [position] = sound(packets.read4ByteTxRx(port, SERVO, 132))
    [told] = sound(packets.readTxRx(port, GRIPPER, 128 + 28, 12))
    age, _, of = (int.from_bytes(bytes(told[at : at + 4]), "little") for at in (0, 4, 8))
    print(position, of, age)
port.closePort()
