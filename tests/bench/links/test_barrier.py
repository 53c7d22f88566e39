"""Two processes in lock-step: the same bits on every link, whatever strangers send; and peers that go missing."""

import importlib.util
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from bench.links.available import MULTICAST_ROUTE, multicast_works
from bench.links.barrier import BarrierClient, BarrierServer, PeerLost, PeerSilent
from bench.links.frame import BENCH, FOREIGN, make_frame, new_frames
from bench.links.lockstep_frames import MOST_FRAMES
from bench.links.registry import open_link
from bench.links.virtual import VirtualLink
from signals.errors import LinkError, RunError

PEER = Path(__file__).with_name("lockstep_peer.py")
TICKS = 400
START_PATIENCE_S = 240.0
"""A kernel in user mode on a busy machine imports and compiles for minutes; a peer that ends is seen at once."""


@pytest.fixture(params=["udp", "udp_loopback"])
def kind(request: pytest.FixtureRequest) -> str:
    if request.param == "udp" and not multicast_works():
        pytest.skip(f"no multicast route; {MULTICAST_ROUTE}")
    return request.param


def peer_module():
    spec = importlib.util.spec_from_file_location("lockstep_peer", PEER)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Bench:
    """The bench's side: sends frames that depend on everything received, keeps a digest of it."""

    def __init__(self) -> None:
        self.node = peer_module().Node()
        self.sent = new_frames(64)
        self.count = 0

    def tick(self, tick: int, frames, received: int) -> int:
        self.count = self.node.tick(tick + 1, frames, received, self.sent)
        self.sent["tick"][: self.count] = tick
        self.sent["sender"][: self.count] = BENCH
        return self.count


def reference() -> tuple[str, str]:
    """Digests of both sides when one process calls them in turn: frames of tick n are seen in n + 1."""
    bench, ecu = Bench(), peer_module().Node()
    from_ecu, from_bench, number, sent = new_frames(64), new_frames(64), 0, 0
    for tick in range(TICKS):
        from_bench[:sent] = bench.sent[:sent]
        answer = new_frames(64)
        answers = ecu.tick(tick, from_bench, sent, answer)
        sent = bench.tick(tick, from_ecu, number)
        from_ecu, number = answer, answers
    return bench.node.digest(), ecu.digest()


def start_peer(link_text: str, barrier: BarrierServer, *arguments: int) -> subprocess.Popen[str]:
    command = [sys.executable, str(PEER), link_text, str(barrier.path), *(str(number) for number in arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=PEER.parents[3], env=None)


def run_in_two_processes(kind: str, tmp_path: Path, disturb=None) -> tuple[str, str, int]:
    """Digests of both sides and the number of strangers' frames that the bench saw."""
    bench, strangers = Bench(), 0
    with open_link(kind, role="bench") as link:
        barrier = BarrierServer(tmp_path / "barrier")
        peer = start_peer(link.text, barrier)
        barrier.wait_for_peer(START_PATIENCE_S, lambda: peer.poll() is None)
        frames, count = new_frames(4096), 0
        for tick in range(TICKS):
            if disturb is not None:
                disturb(link.text, tick)
            barrier.begin(tick, bench.sent, bench.count)
            link.send(bench.sent, bench.tick(tick, frames, count))
            count = barrier.finish(link, frames)
            senders = frames["sender"][:count]
            strangers += int((senders == FOREIGN).sum())
            assert set(frames["tick"][:count]) <= {tick}
            assert sorted(senders) == senders.tolist()
        barrier.close()
        output, _ = peer.communicate(timeout=30)
    return bench.node.digest(), output.strip(), strangers


def test_two_processes_see_what_one_process_sees(kind: str, tmp_path: Path) -> None:
    assert run_in_two_processes(kind, tmp_path)[:2] == reference()


def test_frames_of_strangers_do_no_harm(kind: str, tmp_path: Path) -> None:
    """Strangers send rubbish, frames of the pair's own identifiers, and copies of the pair's own frames."""
    stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    heard: list[bytes] = []

    def disturb(text: str, tick: int) -> None:
        address = text.split(":")[1:]
        targets = [(address[0], int(address[1]))] if text.startswith("udp:") else []
        targets = targets or [("127.0.0.1", int(port)) for port in address]
        for target in targets:
            stranger.sendto(b"rubbish", target)
            for frame in (make_frame(0x300), make_frame(0x301, bytes(8)), make_frame(0x7, b"\x01\x02")):
                stranger.sendto(datagram(frame), target)
            if heard:
                stranger.sendto(heard[-1], target)
        heard.append(datagram(make_frame(0x300)))

    *digests, strangers = run_in_two_processes(kind, tmp_path, disturb)
    stranger.close()
    assert tuple(digests) == reference()
    assert strangers >= 3 * (TICKS - 2)


def datagram(frame) -> bytes:
    from bench.links.message_pack import SLOT_BYTES, pack_frames, stamp_bytes

    slots, sizes = np.zeros((1, SLOT_BYTES), np.uint8), np.zeros(1, np.int64)
    pack_frames(frame, 1, stamp_bytes(0), slots, sizes)
    return slots[0, : sizes[0]].tobytes()


def test_a_peer_that_ends_is_reported_at_once(tmp_path: Path) -> None:
    with open_link("udp_loopback", role="bench") as link:
        barrier = BarrierServer(tmp_path / "barrier", timeout_s=60.0)
        peer = start_peer(link.text, barrier, 3)
        barrier.wait_for_peer(30.0)
        for tick in range(4):
            barrier.begin(tick, new_frames(1), 0)
            if tick < 3:
                barrier.finish(link, new_frames(64))
        with pytest.raises(PeerLost, match="ECU ended in tick 3"):
            barrier.finish(link, new_frames(64))
    peer.communicate(timeout=30)
    barrier.close()
    assert not barrier.path.exists()


def test_a_peer_that_never_answers_is_reported_after_the_timeout(tmp_path: Path) -> None:
    with VirtualLink("silent peer", "bench") as link:
        barrier = BarrierServer(tmp_path / "barrier", timeout_s=0.05)
        client = BarrierClient(barrier.path)
        barrier.wait_for_peer()
        barrier.begin(0, new_frames(1), 0)
        with pytest.raises(PeerSilent, match=r"never answered tick 0: no answer within 0\.05 s"):
            barrier.finish(link, new_frames(64))
        client.close()
        barrier.close()


def test_a_peer_that_never_joins_is_reported(tmp_path: Path) -> None:
    barrier = BarrierServer(tmp_path / "barrier")
    with pytest.raises(PeerSilent, match="did not join"):
        barrier.wait_for_peer(0.0)
    with pytest.raises(PeerLost, match="before it joined"):
        barrier.wait_for_peer(1.0, lambda: False)
    barrier.close()


def test_a_client_without_a_bench_says_so(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no bench listens"):
        BarrierClient(tmp_path / "nobody")


def test_a_frame_lost_on_the_link_is_an_error_not_a_wrong_result(tmp_path: Path) -> None:
    with VirtualLink("lossy", "bench") as link:
        barrier = BarrierServer(tmp_path / "barrier", timeout_s=0.05)
        client = BarrierClient(barrier.path)
        barrier.wait_for_peer()
        barrier.begin(0, new_frames(1), 0)
        with VirtualLink("lossy", "ecu") as ecu:
            assert client.begin(ecu, new_frames(64)) == (0, 0)
            client.finish(make_frame(0x210), 1)  # announced, never sent
        with pytest.raises(LinkError, match="1 of 1 frames that the peer sent in tick 0 never came"):
            barrier.finish(link, new_frames(64))
        client.close()
        barrier.close()


def test_frames_come_by_channel_then_order_of_sending_and_early_ones_wait(tmp_path: Path) -> None:
    with VirtualLink("two channels", "bench") as bench, VirtualLink("two channels", "ecu") as ecu:
        barrier = BarrierServer(tmp_path / "barrier")
        client = BarrierClient(barrier.path)
        barrier.wait_for_peer()
        frames = np.concatenate([make_frame(0x11, channel=1), make_frame(0x12), make_frame(0x13, channel=1)])
        bench.send(frames, 3)
        barrier.begin(1, frames, 3)
        bench.send(make_frame(0x99), 1)  # of tick 1, already there when the ECU runs its tick 1
        into = new_frames(64)
        assert client.begin(ecu, into) == (1, 3)
        assert into["identifier"][:3].tolist() == [0x12, 0x11, 0x13]
        assert set(into["tick"][:3]) == {0}
        client.finish(new_frames(1), 0)
        assert barrier.finish(bench, new_frames(64)) == 0
        barrier.begin(2, make_frame(0x99), 1)
        assert client.begin(ecu, into) == (2, 1)
        assert into["identifier"][0] == 0x99
        assert into["tick"][0] == 1
        assert into["sender"][0] == BENCH
        client.close()
        barrier.close()


def test_a_flood_of_strangers_before_the_pairs_frame_does_no_harm(tmp_path: Path) -> None:
    """More frames than are held at first, all before the one that is waited for."""
    with VirtualLink("flood", "bench") as bench, VirtualLink("flood", "ecu") as ecu:
        barrier = BarrierServer(tmp_path / "barrier")
        client = BarrierClient(barrier.path)
        barrier.wait_for_peer()
        stranger = new_frames(3 * MOST_FRAMES // 2)
        stranger["identifier"] = 0x7FF
        bench.send(stranger, len(stranger))
        bench.send(make_frame(0x120), 1)
        barrier.begin(1, make_frame(0x120), 1)
        into = new_frames(64)
        assert client.begin(ecu, into) == (1, 1)
        assert into["identifier"][0] == 0x120
        client.finish(new_frames(1), 0)
        barrier.begin(2, new_frames(1), 0)
        assert client.begin(ecu, into) == (2, 64)  # as many strangers as there is room for
        assert set(into["sender"]) == {FOREIGN}
        client.close()
        barrier.close()


def test_the_bench_ending_the_run_ends_the_client(tmp_path: Path) -> None:
    barrier = BarrierServer(tmp_path / "barrier")
    client = BarrierClient(barrier.path)
    barrier.wait_for_peer()
    closing = threading.Thread(target=barrier.close)
    closing.start()
    with VirtualLink("ended", "ecu") as link:
        assert client.begin(link, new_frames(4)) is None
    closing.join()
    client.close()
