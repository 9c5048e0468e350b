#!/usr/bin/env python3
"""What viewers of the live page cost the hands: round trips with and without them, in turns.

usage: observed.py PROGRAMS [--hands 16] [--viewers 5] [--seconds 10] [--rounds 3] [--viewer-cores LIST]

Starts feltwire-server with scenes/room.json and the live page, and simulated hands at 1 kHz that press on it. Each round they run once
without viewers and once with viewers, programs that read every picture and draw nothing. Prints for each run the median over the hands of
the round trip's p50 and p99 [us], and of the scene's thread how long it waited for a core, a wake-up [us] (Linux, schedstat). Last the
ratio of the medians over the rounds. Browsers draw elsewhere: --viewer-cores says where the viewers run, 1 say, or 2,3.
"""

import argparse
import json
import pathlib
import socket
import statistics
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def view(port, token):
    """A viewer: reads until the connection ends."""
    line = socket.create_connection(("127.0.0.1", port))
    host = f"127.0.0.1:{port}"
    line.sendall((f"GET /live HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                  "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                  "Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n").encode())
    text = json.dumps({"token": token}).encode()
    if len(text) > 125:
        sys.exit("the token is longer than this viewer can say")
    line.sendall(bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)  # a mask of zeros
    while line.recv(65536):
        pass


def read_lines(server):
    """The ports of control and page, from what the server prints."""
    control = page = None
    for text in server.stdout:
        if text.startswith("listening: control tcp "):
            control = int(text.split()[3].rstrip(","))
        if text.startswith("live page: "):
            page = int(text.rsplit(":", 1)[1].split("/")[0])
            break
    if control is None or page is None:
        sys.exit("the server did not start")
    return control, page


def scene_thread(server):
    """([ns] it ran, [ns] it waited for a core, times it got one) of the thread of the server that ran most."""
    best = (0, 0, 0)
    for task in pathlib.Path(f"/proc/{server.pid}/task").iterdir():
        ran, waited, times = (int(word) for word in (task / "schedstat").read_text().split())
        best = max(best, (ran, waited, times))
    return best


def run(programs, state, server, ports, args, viewers):
    """One run. Returns p50, p99 [us], wait a wake-up [us]."""
    control, page = ports
    token = (state / "local.token").read_text().strip()
    watching = []
    for _ in range(viewers):
        command = [sys.executable, __file__, "--view", str(page), token]
        if args.viewer_cores:
            command = ["taskset", "-c", args.viewer_cores] + command
        watching.append(subprocess.Popen(command))
    before = scene_thread(server)
    hands = [subprocess.Popen(
        [programs / "feltwire-client", "--connect", f"127.0.0.1:{control}", "--fingerprint-file", state / "fingerprint", "--token-file",
         state / "local.token", "--scene", "room", "--device", "simulated:path=press", "--duration", str(args.seconds), "--report",
         state / f"hand{i}.json"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for i in range(args.hands)]
    failed = sum(hand.wait() != 0 for hand in hands)
    after = scene_thread(server)
    for viewer in watching:
        viewer.terminate()
        viewer.wait()
    if failed:
        sys.exit(f"{failed} hands failed")
    trips = [json.loads((state / f"hand{i}.json").read_text())["round_trip_us"] for i in range(args.hands)]
    waited = (after[1] - before[1]) / max(after[2] - before[2], 1) * 1e-3
    return statistics.median(t["p50"] for t in trips), statistics.median(t["p99"] for t in trips), waited


def main():
    if sys.argv[1:2] == ["--view"]:
        return view(int(sys.argv[2]), sys.argv[3])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--hands", type=int, default=16)
    parser.add_argument("--viewers", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--viewer-cores", default="")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        state = pathlib.Path(folder)
        server = subprocess.Popen(
            [args.programs / "feltwire-server", "--scene", SOURCE / "scenes" / "room.json", "--port", "0", "--web", "0", "--state", state],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            ports = read_lines(server)
            figures = {0: [], args.viewers: []}
            print("round viewers    p50    p99  wait  [us]")
            for number in range(1, args.rounds + 1):
                for viewers in figures if number % 2 else reversed(figures):
                    figures[viewers].append(run(args.programs, state, server, ports, args, viewers))
                    print(f"{number:5} {viewers:7} " + " ".join(f"{value:6.1f}" for value in figures[viewers][-1]), flush=True)
            medians = {viewers: [statistics.median(column) for column in zip(*rows)] for viewers, rows in figures.items()}
            print("ratio         " + " ".join(f"{seen / unseen:6.2f}" for seen, unseen in zip(medians[args.viewers], medians[0])))
        finally:
            server.terminate()
            server.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
