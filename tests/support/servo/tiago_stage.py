"""A simulated TIAGo whose joint states can fail, and a node that hears what it is sent."""

import queue

from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.robots.tiago_topics import TiagoTopics
from patience import PATIENCE, until


class Faulty(TiagoTopics):
    """Controllers whose joint states cease or stand still on demand."""

    def __init__(self, robot):
        super().__init__(robot)
        self.robot = robot
        self.silent = self.frozen = False
        self.joint_states = 0

    def hears(self, client):
        """Whether the controllers have discovered who commands them: earlier commands are lost."""
        topics = [drive.topic for drive in client._drives.values()]
        return all(self._ros.node.count_publishers(topic) for topic in topics)

    def _publish_state(self):
        if self.frozen:
            last = self._robot.state() if self._robot is self.robot else None
            if last is not None:
                self._robot = Still(self.robot, last)
        if not self.silent:
            self.joint_states += 1
            super()._publish_state()


class Still:
    """A robot whose readings repeat themselves, though it moves."""

    def __init__(self, robot, last):
        self._robot, self._last = robot, last

    def state(self):
        return self._last

    def __getattr__(self, name):
        return getattr(self._robot, name)


class Listener:
    """An independent node that hears what is commanded and what is published."""

    def __init__(self):
        self.ros = Ros2Node("listener")
        self.node = self.ros.node
        self.ros.start()

    def hear(self, kind, topic):
        """Collect the messages that arrive from now on: networks connect late, earlier ones are lost."""
        heard = queue.Queue()
        subscription = self.node.create_subscription(kind, topic, heard.put, 50)
        until(subscription.get_publisher_count, f"a publisher of {topic}")
        return heard

    def call(self, service, server):
        """Call a service of the node `server`, once that has discovered who reads the answer."""
        from std_srvs.srv import Trigger

        client = self.node.create_client(Trigger, service)
        assert client.wait_for_service(PATIENCE)
        until(lambda: server.count_clients(service), f"a client of {service}")
        try:
            future = client.call_async(Trigger.Request())
            until(future.done)
            return future.result()
        finally:
            self.node.destroy_client(client)
            until(lambda: not server.count_clients(service), f"no client of {service}")
