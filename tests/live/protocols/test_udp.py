"""UDP: what arrives by a socket, who may send, how much, and what is no message."""

from __future__ import annotations

import socket
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.errors import InputError
from halfphysics.live.protocols import vmc
from halfphysics.live.protocols.endpoint import Endpoint, check_apart, endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.udp import MAX_RATE, SILENCE, UdpReceiver, UdpSender
from support.live_frames import BODY, PERSON, any_pose, furthest, outgoing

ANYWHERE = Endpoint("vmc", "127.0.0.1", 0)


class Echo:
    """A decoder to which every datagram that does not begin with "x" is a pose."""

    calibrated = 0

    def decode(self, data, now):
        if data.startswith(b"x"):
            raise Malformed("found x")
        return [data]

    def calibrate(self):
        self.calibrated += 1


def eventually(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_poses_go_through_sockets():
    """Sender and receiver of VMC, as they are in a live session."""
    poses, pose = [], any_pose(1)
    receiver = vmc.receiver(ANYWHERE, PERSON, BODY)
    receiver.start(poses.append)
    sender = vmc.sender(receiver.endpoint, PERSON, BODY)
    for frame in range(3):
        sender.send(outgoing(pose, frame))
    eventually(lambda: len(poses) == 3)
    sender.stop()
    receiver.stop()
    assert furthest(poses[-1].pose, pose) < 1e-4
    assert poses[-1].source.startswith("vmc:127.0.0.1")
    assert receiver.counts.malformed == sender.dropped == 0


def test_a_port_that_is_taken_is_said_and_freed():
    first = UdpReceiver(ANYWHERE, Echo())
    first.start(lambda pose: None)
    where = first.endpoint
    with pytest.raises(InputError, match="cannot listen there"):
        UdpReceiver(where, Echo()).start(lambda pose: None)
    first.stop()
    again = UdpReceiver(where, Echo())
    again.start(lambda pose: None)
    again.stop()


def test_nothing_is_delivered_after_stop():
    poses = []
    receiver = UdpReceiver(ANYWHERE, Echo())
    receiver.start(poses.append)
    port = receiver.endpoint.port
    receiver.stop()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.sendto(b"late", ("127.0.0.1", port))
    time.sleep(0.05)
    assert poses == []


def test_one_machine_at_a_time():
    poses, receiver = [], UdpReceiver(ANYWHERE, Echo())
    receiver.take(b"a", "10.0.0.1", 0.0, poses.append)
    receiver.take(b"b", "10.0.0.2", 1.0, poses.append)
    receiver.take(b"c", "10.0.0.1", 1.5, poses.append)
    receiver.take(b"d", "10.0.0.2", 1.5 + SILENCE + 0.1, poses.append)
    assert poses == [b"a", b"c", b"d"]
    assert receiver.counts.other_senders == 1


def test_what_is_no_message_takes_no_turn():
    """Noise from elsewhere does not keep the real sender out."""
    poses, receiver = [], UdpReceiver(ANYWHERE, Echo())
    receiver.take(b"x", "10.0.0.2", 0.0, poses.append)
    receiver.take(b"a", "10.0.0.1", 0.1, poses.append)
    assert (poses, receiver.counts.malformed) == ([b"a"], 1)
    assert receiver.counts.last_error == "found x"


def test_a_mistake_of_ours_ends_nothing():
    class Broken(Echo):
        def decode(self, data, now):
            raise ZeroDivisionError("of ours")

    receiver = UdpReceiver(ANYWHERE, Broken())
    receiver.take(b"a", "h", 0.0, lambda pose: None)
    assert (receiver.counts.malformed, receiver.counts.datagrams) == (1, 0)
    assert receiver.counts.last_error == "ZeroDivisionError: of ours"


def test_what_is_not_taken_is_said():
    receiver = UdpReceiver(Endpoint("vmc", "127.0.0.1", 7), Echo())
    assert receiver.trouble == "nothing was heard"
    receiver.take(b"x", "10.0.0.1", 0.0, lambda pose: None)
    said = "datagrams not understood as vmc: 1 (found x), no pose in what was heard"
    assert receiver.trouble == said
    receiver.counts.last_error = "found \x1b[2J"
    assert "(found ?[2J)" in receiver.trouble
    receiver.take(b"a", "10.0.0.1", 0.1, lambda pose: None)
    receiver.take(b"a", "10.0.0.2", 0.2, lambda pose: None)
    assert receiver.trouble.endswith("datagrams of a second machine, left out: 1")
    taken = UdpReceiver(ANYWHERE, Echo())
    taken.take(b"a", "10.0.0.1", 0.0, lambda pose: None)
    assert taken.trouble == ""


def test_the_rate_is_bounded():
    poses, receiver = [], UdpReceiver(ANYWHERE, Echo())
    for _ in range(MAX_RATE + 100):
        receiver.take(b"a", "h", 5.0, poses.append)
    assert (len(poses), receiver.counts.over_rate) == (MAX_RATE, 100)
    receiver.take(b"a", "h", 6.0, poses.append)
    assert len(poses) == MAX_RATE + 1


def test_calibration_some_seconds_after_the_first_pose():
    decoder = Echo()
    receiver = UdpReceiver(ANYWHERE, decoder, calibrate=3.0)
    for now, times in ((10.0, 0), (12.9, 0), (13.0, 1), (20.0, 1)):
        receiver.take(b"a", "h", now, lambda pose: None)
        assert decoder.calibrated == times


def test_a_sender_whom_nobody_hears_goes_on():
    class Words:
        def encode(self, frame):
            return [b"word"] * 5

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    sender = UdpSender(Endpoint("vmc", "127.0.0.1", port), Words())
    for _ in range(20):
        sender.send(None)
    sender.stop()
    assert sender.sent + sender.dropped == 100
    for host in ("no.such.host.invalid", 70 * "a"):
        with pytest.raises(InputError, match="host is not found"):
            UdpSender(Endpoint("vmc", host, 1), Words())


@settings(max_examples=100)
@given(st.lists(st.binary(max_size=100), max_size=10))
def test_noise_never_leaves_the_receiver(datagrams):
    receiver = vmc.receiver(ANYWHERE, PERSON, BODY)
    for data in datagrams:
        receiver.take(data, "h", 0.0, lambda pose: None)
    counts = receiver.counts
    assert counts.datagrams + counts.malformed == len(datagrams)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("vmc", ("vmc", "127.0.0.1", 7)),
        ("vmc:39540", ("vmc", "127.0.0.1", 39540)),
        ("vmc:192.168.0.7", ("vmc", "192.168.0.7", 7)),
        ("vmc:host:1", ("vmc", "host", 1)),
        ("vmc:[::1]:9", ("vmc", "::1", 9)),
    ],
)
def test_endpoints(text, expected):
    assert endpoint(text, 7) == Endpoint(*expected)
    assert endpoint(str(endpoint(text, 7)), 7) == Endpoint(*expected)


@pytest.mark.parametrize("text", ["", ":1", "vmc:70000", "vmc:a b:1", "vmc:u@h:1", "vmc:a/b:1"])
def test_what_is_no_endpoint_is_said(text):
    with pytest.raises(InputError, match="expected PROTOCOL"):
        endpoint(text, 7)


@pytest.mark.parametrize(
    ("listen", "forward", "said"),
    [
        (["vmc:7", "vmc:7"], [], r"listen: found vmc:127\.0\.0\.1:7 for two people.*:8$"),
        (["vmc:7", "mocopi:localhost:7"], [], "two people"),
        ([], ["vmc:10.0.0.1:7", "vmc:10.0.0.1:7"], r"forward: .*two people"),
        (["vmc:7"], ["vmc:7"], r"forward: found vmc:127\.0\.0\.1:7, where poses come in"),
        (["vmc:0.0.0.0:65535"], ["vmc:65535"], r"such as vmc:127\.0\.0\.1:65534$"),
        (["vmc:1", "vmc:7"], ["mocopi:8", "vmc:localhost:7"], "follow themselves"),
        (["vmc:7"], ["vmc:0.0.0.0:7"], "follow themselves"),
        (["vmc:[::1]:7"], ["vmc:[::]:7"], "follow themselves"),
        (["vmc:7"], ["vmc:LOCALHOST:7"], "follow themselves"),
        (["vmc:[::1]:7"], ["vmc:localhost:7"], "follow themselves"),
        (["vmc:Host:7"], ["vmc:host:7"], "follow themselves"),
        (["vmc:7", "vmc:0.0.0.0:7"], [], "two people"),
        (["vmc:0.0.0.0:7"], ["vmc:localhost:7"], "follow themselves"),
        (["vmc:[::]:7"], ["vmc:7"], "follow themselves"),
        (["vmc:[::]:7"], ["vmc:[::1]:7"], "follow themselves"),
        (["vmc:7"], ["vmc:127.1:7"], "follow themselves"),
        (["vmc:7"], ["vmc:0x7f.1:7"], "follow themselves"),
        (["vmc:0.0.0.0:7"], ["vmc:127.1:7"], "follow themselves"),
        (["vmc:7"], ["vmc:[::ffff:127.0.0.1]:7"], "follow themselves"),
        (
            ["vmc:7"],
            ["rokoko:7"],
            r"found rokoko:127\.0\.0\.1:7, a port that people's poses come in by, of vmc:.*:8$",
        ),
    ],
)
def test_what_goes_out_does_not_come_in_again(listen, forward, said):
    with pytest.raises(InputError, match=said):
        check_apart([endpoint(t, 1) for t in listen], [endpoint(t, 1) for t in forward])


def test_this_machine_s_address_on_the_network_is_heard_by_who_listens_on_all():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as route:
        try:
            route.connect(("198.51.100.1", 9))  # nothing is sent
        except OSError:
            pytest.skip("this machine has no network")
        own = route.getsockname()[0]
    with pytest.raises(InputError, match="follow themselves"):
        check_apart([endpoint("vmc:0.0.0.0:7", 1)], [endpoint(f"vmc:{own}:7", 1)])
    check_apart([endpoint("vmc:0.0.0.0:7", 1)], [endpoint(f"vmc:{own}:8", 1)])
    check_apart([endpoint("vmc:0.0.0.0:7", 1)], [endpoint("vmc:198.51.100.1:7", 1)])


def test_this_machine_s_name_is_this_machine(monkeypatch):
    """It is the only name that is looked up."""
    asked = []

    def lookup(name, port, **options):
        asked.append(name)
        return [(socket.AF_INET, socket.SOCK_DGRAM, 17, "", ("127.0.1.1", 0))]

    monkeypatch.setattr(socket, "gethostname", lambda: "Studio.example.org")
    monkeypatch.setattr(socket, "getaddrinfo", lookup)
    everywhere = [endpoint("vmc:0.0.0.0:7", 1)]
    for name in ("studio", "Studio.local", "studio.example.org"):
        with pytest.raises(InputError, match="follow themselves"):
            check_apart(everywhere, [endpoint(f"vmc:{name}:7", 1)])
    assert asked == ["studio", "studio.local", "studio.example.org"]
    check_apart(everywhere, [endpoint("vmc:stage.example.org:7", 1)])
    check_apart([endpoint("vmc:7", 1)], [endpoint("vmc:studio:7", 1)])  # it is at 127.0.1.1
    assert "stage.example.org" not in asked


def test_nobody_is_sent_to_port_0():
    with pytest.raises(InputError, match=r"vmc:127\.0\.0\.1:0: found port 0, expected .*:39540$"):
        vmc.sender(ANYWHERE, PERSON, BODY)


def test_places_of_their_own_are_fine():
    listen = [endpoint(text, 1) for text in ("vmc:0", "vmc:0", "vmc:7", "vmc:0.0.0.0:8")]
    forward = [
        endpoint(text, 1) for text in ("vmc:9", "vmc:198.51.100.1:7", "mocopi:198.51.100.1:8")
    ]
    check_apart(listen, forward)
    check_apart([endpoint("vmc:0.0.0.0:7", 1)], [endpoint("vmc:[::1]:7", 1)])  # of IPv4 alone
    check_apart([endpoint("vmc:7", 1)], [endpoint("vmc:[::1]:7", 1)])


def test_loopback_is_known():
    assert endpoint("vmc", 7).is_local
    assert Endpoint("vmc", "localhost", 1).is_local
    assert Endpoint("vmc", "::1", 1).is_local
    assert not Endpoint("vmc", "10.0.0.1", 1).is_local
    assert not Endpoint("vmc", "localhost.evil", 1).is_local


def test_a_flood_of_a_stranger_takes_no_room_from_who_sends():
    poses, receiver = [], UdpReceiver(ANYWHERE, Echo())
    receiver.take(b"a", "h", 5.0, poses.append)
    for _ in range(2 * MAX_RATE):
        receiver.take(b"b", "stranger", 5.1, poses.append)
    receiver.take(b"a", "h", 5.2, poses.append)
    assert len(poses) == 2
    assert receiver.counts.other_senders == 2 * MAX_RATE
