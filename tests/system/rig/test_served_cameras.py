"""The cameras of a rig on YARP: a port each, with equal stamps within a set."""

from contextlib import ExitStack

from grabbergui import sources
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.rig import source
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from grabbergui.rig.served_cameras import ServedCameras
from patience import PATIENCE, until

FAST = "sim:?width=64&height=48&fps=50&exposure=1000"
NAMES = ("left", "right")


def test_the_images_of_a_set_have_equal_stamps_on_yarp():
    with ExitStack() as stack:
        names = NameServer("127.0.0.1", 0)
        names.open()
        stack.callback(names.close)
        address = f"{names.contact.host}:{names.contact.port}"
        entry = {name: CameraEntry(f"{FAST}&serial={name}") for name in NAMES}
        rig = source.of_entry(RigEntry(entry, trigger=TriggerEntry("software", 20)))
        stack.callback(rig.close)
        rig.open()
        rig.start()
        served = ServedCameras(rig)
        stack.callback(served.close)
        served.start()
        queues = {}
        for name in NAMES:
            client = NameClient.find(address)
            stack.enter_context(YarpGrabberServer(served.cameras[name], f"/stereo/{name}", names=client))
            peer = sources.create(f"yarp:/stereo/{name}?nameserver={address}")
            stack.callback(peer.close)
            peer.open()
            queues[name] = peer.open_queue(64)
            peer.start()
        stamps = {name: set() for name in NAMES}

        def three_of_both():
            for name, queue in queues.items():
                stamps[name].add(queue.get(PATIENCE).timestamp_ns)
            return len(stamps["left"] & stamps["right"]) >= 3

        until(three_of_both, "three sets")
        served.cameras["right"].write_feature("ExposureTime", 2000)
        assert rig.cameras["right"].feature("ExposureTime").value == 2000
