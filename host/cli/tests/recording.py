"""Reads a recording with the MCAP library of its authors: counts per topic, types against the schemas, and the estimates' bits. What
is to be of one of Foxglove's own types has to be one: each message is read into the class that Foxglove makes of that type.

recording.py whole FILE | cut FILE
"""

import collections
import json
import struct
import sys
import time
import zlib

from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.json_format import ParseDict
from mcap.reader import NonSeekingReader, make_reader

KINDS = {"integer": int, "string": str, "boolean": bool, "number": (int, float), "object": dict, "array": list}


FOXGLOVE = {"foxglove.Log": Log, "foxglove.SceneUpdate": SceneUpdate}


def protobuf(value, name=""):
    """Times as the JSON of Protocol Buffers has them; all else as it is."""
    if isinstance(value, list):
        return [protobuf(item) for item in value]
    if not isinstance(value, dict):
        return value
    if set(value) == {"sec", "nsec"}:
        if name == "lifetime":
            return f"{value['sec']}.{value['nsec']:09}s"
        return time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(value["sec"])) + f".{value['nsec']:09}Z"
    return {name: protobuf(item, name) for name, item in value.items()}


def check(schema, value, where):
    kind = schema["type"]
    if kind == "number" and value in ("NaN", "inf", "-inf"):
        return
    if not isinstance(value, KINDS[kind]) or (kind in ("integer", "number") and isinstance(value, bool)):
        sys.exit(f"{where} is {value!r}, no {kind}")
    if kind == "array":
        for item in value:
            check(schema["items"], item, where)
    if kind == "object":
        for name, inner in schema.get("properties", {}).items():
            # Without friction a force has no interval, and mostly no rib is near its buckling load.
            if name not in value and ("_interval_" in name or name in ("loaded_rib", "rib_load_percent")):
                continue
            if name not in value:
                sys.exit(f"{where} has no {name}")
            check(inner, value[name], f"{where}.{name}")


def main():
    how, path = sys.argv[1:]
    counts, schemas, schema_of = collections.Counter(), {}, {}
    bits, last, times = 0, None, []
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True) if how == "whole" else NonSeekingReader(file)
        messages = reader.iter_messages(log_time_order=False)
        while True:
            try:
                schema, channel, message = next(messages)
            except StopIteration:
                break
            except Exception as error:  # The end is missing: whatever the library says of it.
                if how == "whole":
                    raise
                print(json.dumps({"end": type(error).__name__}))
                break
            if schema.id not in schemas:
                schemas[schema.id] = json.loads(schema.data)
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            schema_of[channel.topic] = schema.name
            value = json.loads(message.data)
            check(schemas[schema.id], value, channel.topic)
            if schema.name.startswith("foxglove."):
                # Fails on a field that the type does not have, and on a value that the field cannot take.
                ParseDict(protobuf(value), FOXGLOVE[schema.name]())
            counts[channel.topic] += 1
            if schema.name.startswith("fre."):
                undeclared = set(value) - set(schemas[schema.id]["properties"])
                assert not undeclared, f"{channel.topic} has {undeclared}, which its schema does not declare"
            if channel.topic.endswith("/estimate"):
                assert message.sequence == value["sequence"] and message.log_time == message.publish_time
                numbers = [float(value[name]) for name in ("force_x_n", "force_y_n", "standard_deviation_n")]
                bits = zlib.crc32(struct.pack("<3f", *numbers), bits)
                last = value["sequence"]
                times.append(message.log_time)
        if how == "whole":
            file.seek(0)
            summary = make_reader(file).get_summary()
            assert summary.statistics.message_count == sum(counts.values())
    print(json.dumps({"counts": counts, "schemas": schema_of, "bits": bits, "last": last, "times": times[:2]}))


main()
