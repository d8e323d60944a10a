"""A subscriber and a caller by Eclipse Cyclone DDS, which shares no code with the node.

    cyclone.py subscribe NODE FINGERS QOS REPORTS   prints every message as JSON; ends after so many forces, or with the node
    cyclone.py call NODE MAPPING                    reads calls as JSON lines, prints the answers

NODE is the node's whole name, as /arm/fre; ROS_DOMAIN_ID is the domain.
"""

import dataclasses
import json
import math
import os
import sys
import time
from dataclasses import dataclass

# Nothing leaves this machine; read when the library is loaded.
os.environ["CYCLONEDDS_URI"] = (
    "<Domain><General><Interfaces><NetworkInterface name='lo'/></Interfaces><AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>50</MaxAutoParticipantIndex>"
    "<Peers><Peer address='127.0.0.1'/></Peers></Discovery></Domain>"
)

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl.types import array, float32, float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.internal import InvalidSample
from cyclonedds.util import duration

PATIENCE_S = 60.0
DOMAIN = int(os.environ.get("ROS_DOMAIN_ID", "0"))


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Color(IdlStruct, typename="std_msgs::msg::dds_::ColorRGBA_"):
    r: float32
    g: float32
    b: float32
    a: float32


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    force: Vector3
    torque: Vector3


@dataclass
class WrenchStamped(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    header: Header
    wrench: Wrench


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class InterfaceValue(IdlStruct, typename="control_msgs::msg::dds_::InterfaceValue_"):
    interface_names: sequence[str]
    values: sequence[float64]


@dataclass
class DynamicJointState(IdlStruct, typename="control_msgs::msg::dds_::DynamicJointState_"):
    header: Header
    joint_names: sequence[str]
    interface_values: sequence[InterfaceValue]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class CompressedImage(IdlStruct, typename="sensor_msgs::msg::dds_::CompressedImage_"):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class UvCoordinate(IdlStruct, typename="visualization_msgs::msg::dds_::UVCoordinate_"):
    u: float32
    v: float32


@dataclass
class MeshFile(IdlStruct, typename="visualization_msgs::msg::dds_::MeshFile_"):
    filename: str
    data: sequence[uint8]


@dataclass
class Marker(IdlStruct, typename="visualization_msgs::msg::dds_::Marker_"):
    header: Header
    ns: str
    id: int32
    type: int32
    action: int32
    pose: Pose
    scale: Vector3
    color: Color
    lifetime: Duration
    frame_locked: bool
    points: sequence[Point]
    colors: sequence[Color]
    texture_resource: str
    texture: CompressedImage
    uv_coordinates: sequence[UvCoordinate]
    text: str
    mesh_resource: str
    mesh_file: MeshFile
    mesh_use_embedded_materials: bool


@dataclass
class MarkerArray(IdlStruct, typename="visualization_msgs::msg::dds_::MarkerArray_"):
    markers: sequence[Marker]


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    type: uint8
    bool_value: bool
    integer_value: int64
    double_value: float64
    string_value: str
    byte_array_value: sequence[uint8]
    bool_array_value: sequence[bool]
    integer_array_value: sequence[int64]
    double_array_value: sequence[float64]
    string_array_value: sequence[str]


@dataclass
class Parameter(IdlStruct, typename="rcl_interfaces::msg::dds_::Parameter_"):
    name: str
    value: ParameterValue


@dataclass
class SetParametersResult(IdlStruct, typename="rcl_interfaces::msg::dds_::SetParametersResult_"):
    successful: bool
    reason: str


@dataclass
class FloatingPointRange(IdlStruct, typename="rcl_interfaces::msg::dds_::FloatingPointRange_"):
    from_value: float64
    to_value: float64
    step: float64


@dataclass
class IntegerRange(IdlStruct, typename="rcl_interfaces::msg::dds_::IntegerRange_"):
    from_value: int64
    to_value: int64
    step: uint64


@dataclass
class ParameterDescriptor(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterDescriptor_"):
    name: str
    type: uint8
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool
    floating_point_range: sequence[FloatingPointRange]
    integer_range: sequence[IntegerRange]


@dataclass
class ListParametersResult(IdlStruct, typename="rcl_interfaces::msg::dds_::ListParametersResult_"):
    names: sequence[str]
    prefixes: sequence[str]


# Fields of requests and answers, by the services' names.
TRIGGER = ("std_srvs", "Trigger", {"structure_needs_at_least_one_member": uint8}, {"success": bool, "message": str})
SERVICES = {
    "stop": TRIGGER,
    "release": TRIGGER,
    "grip": TRIGGER,
    "relax": TRIGGER,
    "get_parameters": ("rcl_interfaces", "GetParameters", {"names": sequence[str]}, {"values": sequence[ParameterValue]}),
    "get_parameter_types": (
        "rcl_interfaces",
        "GetParameterTypes",
        {"names": sequence[str]},
        {"types": sequence[uint8]},
    ),
    "set_parameters": (
        "rcl_interfaces",
        "SetParameters",
        {"parameters": sequence[Parameter]},
        {"results": sequence[SetParametersResult]},
    ),
    "set_parameters_atomically": (
        "rcl_interfaces",
        "SetParametersAtomically",
        {"parameters": sequence[Parameter]},
        {"result": SetParametersResult},
    ),
    "list_parameters": (
        "rcl_interfaces",
        "ListParameters",
        {"prefixes": sequence[str], "depth": uint64},
        {"result": ListParametersResult},
    ),
    "describe_parameters": (
        "rcl_interfaces",
        "DescribeParameters",
        {"names": sequence[str]},
        {"descriptors": sequence[ParameterDescriptor]},
    ),
}
# What comes before requests and answers.
IDENTITY = {"writer": array[uint8, 16], "sequence_high": int32, "sequence_low": uint32}
HEADERS = {
    "basic": ({**IDENTITY, "instance": str}, {**IDENTITY, "exception": int32}),
    "enhanced": ({}, {}),
    "cyclone": ({"guid": uint64, "number": int64}, {"guid": uint64, "number": int64}),
}

# Without limits of its own: what is lost was lost on the way.
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=10)), Policy.History.KeepAll, Policy.Durability.Volatile)
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepAll, Policy.Durability.Volatile)
USUAL = Qos(Policy.Reliability.Reliable(duration(seconds=10)), Policy.History.KeepLast(10), Policy.Durability.Volatile)
# The one that nodes of ROS 2 write.
PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)


def plain(value: object) -> object:
    """A message as dictionaries and lists."""
    if isinstance(value, IdlStruct):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return [plain(part) for part in value] if isinstance(value, (list, tuple, bytes)) else value


def subscribe(node: str, fingers: int, qos: Qos, reports: int) -> None:
    participant = DomainParticipant(DOMAIN)
    namespace = node.rsplit("/", 1)[0]

    def reader(name: str, kind: type, qos: Qos) -> DataReader:
        return DataReader(participant, Topic(participant, "rt" + name, kind), qos=qos)

    readers = {
        "markers": reader(f"{node}/markers", MarkerArray, RELIABLE),
        "diagnostics": reader("/diagnostics", DiagnosticArray, RELIABLE),
        "joint_states": reader(f"{namespace}/joint_states", JointState, qos),
    }
    for number in range(fingers):
        readers[f"force_state {number}"] = reader(f"{node}/finger_{number}/force_state", DynamicJointState, qos)
    # Last: the node begins with the subscriber of this one.
    for number in range(fingers):
        readers[f"wrench {number}"] = reader(f"{node}/finger_{number}/wrench", WrenchStamped, qos)
    counts = dict.fromkeys(readers, 0)
    began = time.monotonic()
    idle_since = None
    while idle_since is None or time.monotonic() - idle_since < 1.0:
        if time.monotonic() - began > 10 * PATIENCE_S:
            raise SystemExit("it takes too long")
        took = False
        for topic, source in readers.items():
            for message in source.take(N=1000):
                # A writer that leaves says so.
                if isinstance(message, InvalidSample):
                    continue
                took = True
                counts[topic] += 1
                fields = plain(message) if topic.startswith("wrench") else None
                cdr = message.serialize(use_version_2=False).hex()
                hardware = message.status[0].hardware_id if topic == "diagnostics" else None
                print(json.dumps({"topic": topic, "cdr": cdr, "fields": fields, "hardware": hardware}))
        # All forces have come, or their writers have gone: what else there is comes within a second.
        done = all(
            counts[f"wrench {number}"] >= reports
            or (counts[f"wrench {number}"] > 0 and not readers[f"wrench {number}"].get_matched_publications())
            for number in range(fingers)
        )
        # Best effort does not wait for what is late: a live source never stops.
        if not done or (took and qos is RELIABLE):
            idle_since = None
            time.sleep(0.0 if took else 0.002)
        elif idle_since is None:
            idle_since = time.monotonic()
    print(json.dumps({"counts": counts}))


def value(of: object) -> ParameterValue:
    """As ROS 2 wraps it."""
    kind = {bool: 1, int: 2, float: 3, str: 4}[type(of)]
    pick = lambda number, none: of if kind == number else none  # noqa: E731
    return ParameterValue(kind, pick(1, False), pick(2, 0), pick(3, 0.0), pick(4, ""), [], [], [], [], [])


def call(node: str, mapping: str) -> None:
    participant = DomainParticipant(DOMAIN)
    ends: dict[str, tuple[DataWriter, DataReader, type]] = {}
    for number, line in enumerate(sys.stdin):
        asked = json.loads(line)
        service = asked.pop("service")
        package, kind, request_fields, reply_fields = SERVICES[service]
        if service not in ends:
            names = [f"{package}::srv::dds_::{kind}_{end}_" for end in ("Request", "Response")]
            before = HEADERS[mapping]
            request_type = make_idl_struct(f"{kind}Request", names[0], {**before[0], **request_fields})
            reply_type = make_idl_struct(f"{kind}Reply", names[1], {**before[1], **reply_fields})
            answers = Topic(participant, f"rr{node}/{service}Reply", reply_type)
            requests = Topic(participant, f"rq{node}/{service}Request", request_type)
            reader = DataReader(participant, answers, qos=USUAL)
            ends[service] = (DataWriter(participant, requests, qos=USUAL + Qos(PLAIN)), reader, request_type)
        writer, reader, request_type = ends[service]
        if "parameters" in asked:
            asked["parameters"] = [Parameter(name, value(of)) for name, of in asked["parameters"].items()]
        header = {
            "basic": {"writer": [number + 1] * 16, "sequence_high": 0, "sequence_low": number + 1, "instance": ""},
            "enhanced": {},
            "cyclone": {"guid": number + 1, "number": number + 1},
        }[mapping]
        if kind == "Trigger":
            asked["structure_needs_at_least_one_member"] = 0
        print(json.dumps(ask(writer, reader, request_type(**header, **asked), header)), flush=True)


def ask(writer: DataWriter, reader: DataReader, request: IdlStruct, header: dict[str, object]) -> object:
    """Asks until there is an answer: the node may know the reader of its answers later than we know the node."""
    began = time.monotonic()
    while time.monotonic() - began < PATIENCE_S:
        if writer.get_matched_subscriptions() and reader.get_matched_publications():
            writer.write(request)
            again = time.monotonic() + 2.0
            while time.monotonic() < again:
                for reply in reader.take(N=10):
                    answer = plain(reply)
                    # An answer to this request, not to an earlier one.
                    if all(answer[key] == of for key, of in header.items() if key != "instance"):
                        return {key: of for key, of in answer.items() if key not in header}
                time.sleep(0.005)
        time.sleep(0.02)
    raise SystemExit("no answer")


if __name__ == "__main__":
    how, node, *rest = sys.argv[1:]
    if how == "subscribe":
        subscribe(node, int(rest[0]), {"reliable": RELIABLE, "best-effort": BEST_EFFORT}[rest[1]], int(rest[2]))
    else:
        call(node, rest[0])
