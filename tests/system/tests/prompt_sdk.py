"""Closes a finger step by step through ROBOTIS' own SDK, and asks the gripper right after each position of the servo.

Usage: prompt_sdk.py PORT BAUD_RATE SERVO GRIPPER GOAL

Prints the servo's position, and the position and its age in µs that the gripper has answered with.
"""

import sys
import time

from sdk_port import packets, port, sound

SERVO, GRIPPER, GOAL = (int(word) for word in sys.argv[3:6])

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
