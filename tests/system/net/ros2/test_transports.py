"""How Fast DDS sends: in shared memory, but by UDP beside the programs of another user."""

import fcntl
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.net.ros2 import runtime
from grabbergui.net.ros2 import shared_memory as memory
from patience import PATIENCE, PROGRAM, until

PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
RESOURCES = Path(__file__).parents[4] / "resources/ros2"


@pytest.fixture
def segment(tmp_path):
    """The shared memory of a DDS program that runs, with its lock."""
    path = tmp_path / "fastdds_0123456789abcdef"
    path.touch()
    with (tmp_path / f"{path.name}_el").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield path


def test_shared_memory_of_the_same_user_is_ignored(segment):
    assert memory.reason_against(segment.parent) == ""


def test_shared_memory_of_another_user_is_found(segment, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: segment.stat().st_uid + 1)
    assert memory.reason_against(segment.parent) == f"user {segment.owner()} runs ROS 2 programs here"


def test_shared_memory_left_by_an_ended_program_is_ignored(tmp_path, monkeypatch):
    uid = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: uid + 1)
    for name in ("fastdds_0123456789abcdef", "fastdds_0123456789abcdef_el"):
        (tmp_path / name).touch()
    assert memory.reason_against(tmp_path) == ""


@pytest.mark.parametrize(
    "name", ["fastdds_port7411_el", "fastdds_0123456789abcdef", "sem.fastdds_port7411_mutex"]
)
@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/etc/passwd"), Path.mkdir])
def test_what_is_no_file_is_never_left_to_fast_dds(name, make, tmp_path, monkeypatch):
    """At a FIFO it would wait for ever. Without shared memory it opens nothing there."""
    assert memory.reason_against(tmp_path) == ""
    make(tmp_path / name)
    assert str(tmp_path / name) in memory.reason_against(tmp_path)

    really = memory.irregular
    monkeypatch.setattr(memory, "irregular", lambda: really(tmp_path))
    monkeypatch.setenv(PROFILES, "/a/profile/of/the/user.xml")
    with pytest.raises(SourceUnavailableError, match=f"{name} is a"):
        runtime.use_transports(shared_memory=True)


def test_a_port_of_another_user_is_not_shared_even_if_its_program_has_ended(tmp_path, monkeypatch):
    (tmp_path / "fastdds_port7411").touch()
    uid = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: uid + 1)
    assert "fastdds_port7411 is another user's" in memory.reason_against(tmp_path)


def test_rclpy_is_not_imported_where_its_tracing_would_wait_for_ever(tmp_path):
    os.mkfifo(tmp_path / f"lttng-ust-wait-6-{os.getuid() + 1}")  # nothing of this user opens it
    (tmp_path / "lttng-ust-wait-7").touch()
    memory.require_unblocked(tmp_path)
    os.mkfifo(tmp_path / "lttng-ust-wait-6")
    with pytest.raises(SourceUnavailableError, match="lttng-ust-wait-6 is a pipe"):
        memory.require_unblocked(tmp_path)


@pytest.mark.parametrize(("other", "profile"), [("", "fastdds.xml"), ("root", "fastdds-network.xml")])
def test_udp_is_used_beside_another_users_programs(other, profile, monkeypatch):
    monkeypatch.setenv(PROFILES, "")  # so that it is afterwards what it was before
    monkeypatch.delenv(PROFILES)
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    monkeypatch.setattr(memory, "reason_against", lambda: other)
    runtime.use_transports(shared_memory=True)
    assert Path(os.environ[PROFILES]).name == profile
    assert (RESOURCES / profile).exists()


@pytest.mark.parametrize(("shared_memory", "reach"), [(True, "LOCALHOST"), (False, "SUBNET")])
def test_a_variable_that_ros_no_longer_reads_still_keeps_to_this_machine(monkeypatch, shared_memory, reach):
    for variable in (PROFILES, "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.setenv(variable, "")
        monkeypatch.delenv(variable)
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
    monkeypatch.setattr(memory, "reason_against", lambda: "")
    runtime.use_transports(shared_memory=shared_memory)
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == reach
    by_profile = Path(os.environ[PROFILES]).name == "fastdds-loopback.xml"
    assert by_profile is not shared_memory
    assert os.environ["ROS_LOCALHOST_ONLY"] == str(int(shared_memory)), "or shared memory is added"


def test_the_profile_for_lossy_networks_is_kept_and_sends_one_packet_at_a_time(monkeypatch):
    lossy = RESOURCES / "fastdds-lossy.xml"
    monkeypatch.setenv(PROFILES, str(lossy))
    for shared_memory in (True, False):
        runtime.use_transports(shared_memory=shared_memory)
        assert os.environ[PROFILES] == str(lossy)
    sizes = re.findall(r"<maxMessageSize>(\d+)<", lossy.read_text("utf-8"))
    assert sizes == ["1472"], "1500 bytes without the headers of IP and UDP"


A_NODE = """
from grabbergui.net.ros2.runtime import Ros2Node

node = Ros2Node("announced")
print("joined", flush=True)
input()
node.close()
"""


@pytest.mark.ros2
@pytest.mark.parametrize("profile", sorted(path.name for path in RESOURCES.glob("fastdds*.xml")))
def test_programs_that_start_later_are_told_of_ours_more_often_than_every_three_seconds(profile, domain):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    environment = {**os.environ, PROFILES: str(RESOURCES / profile)}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        # A port of RTPS for the 30th program of a domain on this machine.
        other.bind(("127.0.0.1", 7400 + 250 * int(environment["ROS_DOMAIN_ID"]) + 10 + 2 * 29))
        other.settimeout(PATIENCE)
        program = subprocess.Popen(
            [sys.executable, "-c", A_NODE], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        try:
            assert program.stdout.readline() == b"joined\n"
            time.sleep(1)  # the first five come every 0.1 s
            last = time.monotonic()
            announced = []
            while len(announced) < 4:
                assert other.recv(65536).startswith(b"RTPS")
                if time.monotonic() > last + 0.3:
                    last = time.monotonic()
                    announced.append(last)
        finally:
            program.communicate(b"\n")
    assert announced[-1] - announced[0] < 6, "at 3 s each it would be 9"


@pytest.fixture
def discovery_server(monkeypatch, tmp_path):
    """A discovery server of Fast DDS, and the environment of its clients."""
    program = shutil.which(
        "fast-discovery-server", path=os.pathsep.join((f"{sys.prefix}/bin", os.environ["PATH"]))
    )
    if not program:
        pytest.skip("fast-discovery-server is not installed")
    libraries = [
        f"{sys.prefix}/lib",
        *map(str, Path(sys.prefix, "lib").glob("python*/site-packages/ros_*.libs")),
    ]
    environment = {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(libraries)}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    # `fastdds discovery` calls it so: 42 is its command to run a server.
    command = [program, "42", "-i", "0", "-l", "127.0.0.1", "-p", str(port)]
    with (tmp_path / "log").open("w") as log:
        server = subprocess.Popen(command, env=environment, stdout=log, stderr=log, stdin=subprocess.PIPE)
    try:
        until(lambda: "Server started" in (tmp_path / "log").read_text() or server.poll() is not None)
        if server.poll() is not None:
            pytest.skip(f"fast-discovery-server does not run: {(tmp_path / 'log').read_text()}")
        for variable in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_SUPER_CLIENT"):
            monkeypatch.setenv(variable, "")
            monkeypatch.delenv(variable)
        monkeypatch.setenv("ROS_DISCOVERY_SERVER", f"127.0.0.1:{port}")
        yield
    finally:
        server.kill()
        server.communicate()


FOUND_BY_SERVER = """
from contextlib import closing
from grabbergui import sources
from grabbergui.net.ros2.server import Ros2GrabberServer

with closing(sources.create("sim:?width=64&height=48")) as camera:
    camera.open()
    with Ros2GrabberServer(camera, "/cam"), closing(sources.create("ros2:/cam")) as remote:
        remote.open()
        print(remote.feature("Gain").value == 0)
"""


@pytest.mark.ros2
def test_a_camera_is_found_through_a_discovery_server(discovery_server):
    """In a process of its own: there, Fast DDS finds nothing without the server any more."""
    program = [sys.executable, "-c", FOUND_BY_SERVER]
    run = subprocess.run(program, capture_output=True, text=True, timeout=PROGRAM)
    assert (run.returncode, run.stdout.strip()) == (0, "True"), run.stderr


@pytest.mark.parametrize("domain", ["233", "300", "0000000233", "9" * 5000])
def test_a_domain_that_does_not_exist_is_refused_before_fast_dds_ends_the_program(monkeypatch, domain):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with pytest.raises(SourceUnavailableError, match="domains have numbers from 0 to 232"):
        runtime.Ros2Node("nowhere")
