"""A port of ROBOTIS' own SDK, named on the command line: SCRIPT PORT BAUD_RATE …"""

import sys

import dynamixel_sdk as sdk
from dynamixel_sdk import port_handler

port_handler.LATENCY_TIMER = 250  # ms, half of what an answer is waited for: a busy machine needs more than the SDK's 16
port = sdk.PortHandler(sys.argv[1])
packets = sdk.PacketHandler(2.0)
assert port.openPort(), "the port does not open"
assert port.setBaudRate(int(sys.argv[2])), "the port refuses the baud rate"


def sound(answer):
    """What an answer says, if it came and has no error."""
    *data, communication, error = answer
    assert (communication, error) == (sdk.COMM_SUCCESS, 0), packets.getTxRxResult(communication)
    return data
