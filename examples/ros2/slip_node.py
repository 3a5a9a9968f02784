#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 node from a uSkin's topic to an alarm: xServTopic (xela_server_ros2/msg/SensStream) in, /slip (std_msgs/Float32),
/slip_alarm and /slip_cannot_tell (std_msgs/Bool) out. Its arguments are those of `tactel monitor`:

    python3 slip_node.py --profile uskin-4x4 --profile uskin-4x4 --calibration c.toml --rest --alarm

/slip_cannot_tell is true with the line's "cannot_tell", and after half a second without a line.

Sensors are taken by their position, taxels in their order. Tested with messages in their place, not with ROS 2 or a uSkin."""
import json
import os
import subprocess
import sys
import threading
import time

import rclpy
from std_msgs.msg import Bool, Float32
from xela_server_ros2.msg import SensStream

SILENCE = 0.5  # s


def line_of(message):
    """x, y, z of every taxel of every sensor: counts of 16 bits, which the message has with a sign."""
    sensors = sorted(message.sensors, key=lambda sensor: sensor.sensor_pos)
    return ",".join(str(count & 0xffff) for sensor in sensors for taxel in sensor.taxels for count in (taxel.x, taxel.y, taxel.z)) + "\n"


class SlipNode:
    def __init__(self, node, options):
        self.slip, self.alarm = node.create_publisher(Float32, "slip", 10), node.create_publisher(Bool, "slip_alarm", 10)
        self.cannot_tell, self.last = node.create_publisher(Bool, "slip_cannot_tell", 10), time.monotonic()
        node.create_timer(SILENCE, self.listen)
        self.monitor = subprocess.Popen([os.environ.get("TACTEL_PROGRAM", "tactel"), "monitor", "--source", "csv:-", "--quiet", *options],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.answers = threading.Thread(target=self.publish)
        self.answers.start()
        node.create_subscription(SensStream, "xServTopic", self.take, 10)

    def take(self, message):
        try:
            self.monitor.stdin.write(line_of(message))
            self.monitor.stdin.flush()
        except BrokenPipeError:  # monitor has said why
            rclpy.shutdown()

    def publish(self):
        for line in self.monitor.stdout:
            answer = json.loads(line)
            number = next((answer[key] for key in ("left", "slip_upper", "slip_index", "slid", "moved") if answer.get(key) is not None), float("nan"))
            self.slip.publish(Float32(data=number))
            self.alarm.publish(Bool(data=answer.get("alarm", False)))
            self.cannot_tell.publish(Bool(data=answer.get("cannot_tell", False)))
            self.last = time.monotonic()

    def listen(self):
        if time.monotonic() - self.last > SILENCE:
            self.cannot_tell.publish(Bool(data=True))

    def close(self):
        self.monitor.stdin.close()
        self.answers.join()
        return self.monitor.wait()


def main():
    rclpy.init()
    node = rclpy.create_node("tactel")
    slip = SlipNode(node, sys.argv[1:])
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    return slip.close()


if __name__ == "__main__":
    sys.exit(main())
