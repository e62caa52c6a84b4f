// Decodes the messages of a report of palpate_fastdds_peer by ROS 2's message definitions, with
// Foxglove's reader, and prints their numbers and texts as JSON:
//   node decode.mjs FOLDER_WITH_NODE_MODULES REPORT
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const require = createRequire(resolve(process.argv[2]) + "/");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const header = `
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec`;
const vector = "float64 x\nfloat64 y\nfloat64 z";
const separator = "================================================================================";
const definitions = {
  measured_cp: `std_msgs/Header header
geometry_msgs/Pose pose${header}
${separator}
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
${separator}
MSG: geometry_msgs/Point
${vector}
${separator}
MSG: geometry_msgs/Quaternion
${vector}
float64 w`,
  measured_cv: `std_msgs/Header header
geometry_msgs/Twist twist${header}
${separator}
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
${separator}
MSG: geometry_msgs/Vector3
${vector}`,
  measured_cf: `std_msgs/Header header
geometry_msgs/Wrench wrench${header}
${separator}
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
${separator}
MSG: geometry_msgs/Vector3
${vector}`,
  operating_state: `std_msgs/Header header
string state
bool is_homed
bool is_busy${header}`,
};

// In the order of the definition's fields.
const numbers = (value) =>
  typeof value === "number" ? [value] : typeof value === "object" ? Object.values(value).flatMap(numbers) : [];

const report = JSON.parse(readFileSync(process.argv[3], "utf8"));
const result = {};
for (const [topic, definition] of Object.entries(definitions)) {
  const reader = new MessageReader(parse(definition, { ros2: true }));
  const { header: head, ...rest } = reader.readMessage(Buffer.from(report[topic].cdr, "hex"));
  result[topic] = { frame: head.frame_id, stamp: head.stamp.sec, numbers: numbers(rest), state: rest.state };
}
console.log(JSON.stringify(result));
