"""Moves a servo through ROBOTIS' own SDK, and reads its position twice in a row now and then.

Usage: late_sdk.py PORT BAUD_RATE SERVO GRIPPER GOAL

Prints the positions that were the second ones.
"""

import sys
import time

from sdk_port import packets, port, sound

SERVO, GOAL = int(sys.argv[3]), int(sys.argv[5])

# The simulated servo's time passes by reads: it is somewhere else at each.
sound(packets.write4ByteTxRx(port, SERVO, 112, 40))
sound(packets.write1ByteTxRx(port, SERVO, 64, 1))
sound(packets.write4ByteTxRx(port, SERVO, 116, GOAL))
for _ in range(8):
    [first], [second] = (sound(packets.read4ByteTxRx(port, SERVO, 132)) for _ in range(2))
    if first != second:
        print(second)
    # The gripper estimates once a period.
    time.sleep(0.25)
port.closePort()
