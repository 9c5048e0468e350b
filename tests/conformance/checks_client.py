"""Checks of a client: how it joins, what it takes of a server's grant, and what it sends."""
import math
from concurrent.futures import ThreadPoolExecutor

import sealing
import tls13
from checks import check, expect
from control import CODES
from model_admin import Refusal
from model_server import ModelServer
from model_ranges import wrong_device, wrong_parameter
from model_session import finite
from stage import plain, stage

AT_ONCE = 4  # clients


def ends_refused(subject, options=(), **more):
    """(exit status, output, connections, datagrams, requests) of a client that must end by itself."""
    with stage(subject, *options, reconnect=5, duration=3, **more) as scene:
        status, output = scene.run.wait()
        return status, output, scene.server.connections, len(scene.server.datagrams), [entry[1] for entry in scene.server.requests]


@check("C-101", "the first of a connection: a token; back: the client's name of the token, the scene that it opens (`*`: any), its role")
def token_first(subject):
    with stage(subject) as scene:
        scene.until(lambda: scene.server.requests, "a request came")
        name = scene.server.requests[0][1]
        expect(name == "Authenticate", f"the first request is {name}")
        scene.enough(1)
        names = [name for _, name, _, _ in scene.server.requests][:2]
        expect(names == ["Authenticate", "JoinRequest"], f"requests {names}")
        size = scene.server.requests[0][3]
        expect(size <= 512, f"{size} bytes before the token is accepted")
        return f"Authenticate with {size} bytes, then JoinRequest"


@check("C-102", "The client knows the server's certificate by its SHA-256 (DER), or verifies it to an authority and for the host that it "
       "dialled.")
def pinned(subject):
    status, output, _, datagrams, requests = ends_refused(subject, ("--fingerprint", "00" * 32))
    expect(not requests and not datagrams, f"it sent {requests} to a server that it does not trust")
    expect(status != 0, "exit status 0")
    return f"no request, exit status {status}: {output.strip()[-100:]}"


@check("C-103", "TLS 1.3 only; no tickets, no resumption, no early data.")
def only_tls13(subject):
    server = ModelServer(roles=("operator",), version=tls13.TLS12)
    with stage(subject, server=server, duration=1) as scene:
        status, _ = scene.run.wait()
        expect(status != 0 and not server.requests, f"exit status {status}, requests {server.requests}")
    return f"no request to a server that offers TLS 1.2 only, exit status {status}"


@check("C-104", "Client, scene, device and tool names and tokens have at most 128 bytes, the name of a bounding method 64; a message with a "
       "longer one is malformed.")
def join_request(subject):
    with stage(subject) as scene:
        scene.until(lambda: scene.requests("JoinRequest"), "a JoinRequest came")
        one = scene.requests("JoinRequest")[0]
    texts = [one.client, one.scene, one.device.name, one.tool or ""]
    expect(all(len(text.encode()) <= 128 for text in texts), f"names {[len(text) for text in texts]} bytes long")
    field = wrong_parameter(one.parameters)
    expect(field is None, f"{field} is out of its range: {one.parameters}")
    field = wrong_device(one.device)
    expect(field is None, f"{field} of the device is out of its range: {one.device}")
    return "names and parameters within their limits"


@check("C-105", "The others are final, and so are a certificate that is not the one trusted, one of the client's that the server does not take, "
       "a grant that the client does not take (below), and parameters other than those of the session before: the client ends at once and "
       "says why.")
def final_refusals(subject):
    final = ("malformed", "unknown_scene", "unknown_session", "bad_device", "bad_parameters", "unauthenticated", "forbidden", "not_supported",
             "bad_scene", "unknown_tool")

    def one(code):
        def refuse(_joined):
            raise Refusal(code, "refused-by-the-check")
        status, output, connections, datagrams, requests = ends_refused(subject, grant=refuse)
        expect(requests.count("JoinRequest") == 1, f"{code}: asked {requests.count('JoinRequest')} times")
        expect(status != 0 and datagrams == 0, f"{code}: exit status {status}, {datagrams} datagrams")
        expect("refused-by-the-check" in output, f"{code}: it does not say why: {output.strip()[-200:]}")
    expect(set(final) < set(CODES), "the codes")
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(one, final))
    return f"{len(final)} refusals: asked once, no datagram, and the reason is said"


def granted(**fields):
    def grant(joined):
        parameters = {**joined["parameters"], **{name: value for name, value in fields.items() if name in joined["parameters"]}}
        return {**joined, **{name: value for name, value in fields.items() if name not in parameters}, "parameters": parameters}
    return grant


@check("C-109", """A client that speaks no version of the server makes no session; it says the versions of both, and does not ask again.""")
def old_server(subject):
    server = ModelServer(roles=("operator",))
    server.versions = {}  # as programs of version 1
    with stage(subject, server=server, reconnect=5, duration=3) as scene:
        status, output = scene.run.wait()
        told = scene.requests("Authenticate")[0]
        expect(told.newest_protocol >= 2 and told.oldest_protocol <= told.newest_protocol, f"the client says its versions as {told}")
        expect(status != 0 and not server.datagrams, f"exit status {status}, {len(server.datagrams)} datagrams")
        expect(server.connections == 1, f"it connected {server.connections} times")
        expect("version 1" in output, f"it does not say why: {output.strip()[-200:]}")
    return output.strip()[-150:]


@check("C-110", """A client makes no session if one has another length, or if both are equal; it names the field, and does not ask again.""")
def wrong_secrets(subject):
    good = bytes(range(sealing.SECRET))
    wrong = [{"secret_up": good[1:]}, {"secret_down": good + b"x"}, {"secret_up": None}, {"secret_up": good, "secret_down": good}]

    def one(fields):
        status, output, connections, datagrams, _ = ends_refused(subject, grant=lambda joined: {**joined, **fields})
        expect(status != 0 and datagrams == 0 and connections == 1, f"{fields}: exit status {status}, {datagrams} datagrams, {connections} joins")
        expect(next(iter(fields)) in output, f"{fields}: it does not say why: {output.strip()[-200:]}")
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(one, wrong))
    return f"{len(wrong)} answers with secrets of 31, 33 and no bytes, and with two equal ones, make no session"


@check("C-106", "For any other answer the client makes no session: it names the field, the requested and the granted value, and does not ask "
       "again.")
def wrong_grants(subject):
    grants = {"mode": "contact_frame", "projection": 0, "storage": 1, "side": 0, "servo_period": 0.001, "operator_damping": 1.0,
              "velocity_cutoff": 10.0, "hold_time": 0.3, "c1": 5.0, "reference": 1, "coupling_stiffness": 100.0, "coupling_damping": 1.0,
              "tool_mass": 1.0, "packet_interval": 0, "redundancy": 9, "batch": 2, "position_deadband": 0.6, "force_deadband": math.nan,
              "keep_alive": 0.4, "session": 0, "silence_timeout": 0.05, "start_position": (0.0, 0.0, 1000.1), "start_normal": (0.0, 0.0, 1.01),
              "stiffness": -1.0}
    more = [("hold_time", 0.05), ("side", 2), ("silence_timeout", 3601.0), ("stiffness", 1.1e9), ("start_position", (math.nan, 0.0, 0.0))]

    def one(case):
        name, value = case
        status, output, connections, datagrams, requests = ends_refused(subject, grant=granted(**{name: value}))
        expect(datagrams == 0, f"{name} = {value} is granted: {datagrams} datagrams came")
        expect(status != 0 and requests.count("JoinRequest") == 1, f"{name} = {value}: exit status {status}, requests {requests}")
        words = name.replace("_", " ")
        # A session of 0 is no message of feltwire, so it has no field to name.
        expect(name == "session" or name in output or words in output, f"{name} = {value}: the field is not named: {output.strip()[-200:]}")
    cases = [*grants.items(), *more]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(one, cases))
    return f"{len(cases)} grants: no session, asked once, the field is named"


@check("C-107", "A client that asked for a tool has no session if the reply names another tool, or none")
def other_tool(subject):
    for tool in (None, "another"):
        status, _, _, datagrams, _ = ends_refused(subject, ("--tool", "mine"), grant=granted(tool=tool))
        expect(datagrams == 0 and status != 0, f"tool {tool} is granted: {datagrams} datagrams, exit status {status}")
    with stage(subject, "--tool", "mine", grant=granted(tool="mine")) as scene:
        scene.enough(1)
    return "no session with another tool or none"


@check("C-108", "With `packet_interval` n above 1, one datagram is sent every n servo ticks, with `batch` m of the n new samples, evenly spaced, "
       "the newest among them. After these come the k samples that travelled before once more (k = `redundancy`, 0 to 8, m + k at most 9), "
       "so that up to k / m lost datagrams in a row lose nothing.")
def traffic(subject):
    fields = {"packet_interval": 4, "batch": 2, "redundancy": 4, "hold_time": 0.1, "keep_alive": 0.05}
    with stage(subject, grant=granted(**fields), duration=300) as scene:
        scene.enough(25)
        tables = [table for _, _, table, _ in scene.datagrams()]
    late = 0
    for before, table in zip(tables[5:], tables[6:]):
        indices = [one.index for one in table.samples]
        step = indices[0] - before.samples[0].index
        expect(len(indices) == 6 and indices[0] - indices[1] == 2, f"samples {indices}")
        late += step != 4
        expect(indices[2:4] == [one.index for one in before.samples[:2]] or step > 4, f"samples {indices} after {before.samples[0].index}")
    expect(late <= len(tables) // 4, f"{late} of {len(tables)} datagrams are not 4 ticks apart")
    return "granted n = 4, m = 2, k = 4: every 4 ticks the samples i, i - 2 and the four that travelled before"


def run_of_samples(subject, count=60, **more):
    with stage(subject, answer=plain((0.5, 0.0, 0.0)), duration=300, **more) as scene:
        scene.enough(count)
        scene.run.stop()
        expect(not scene.dropped(), f"the server dropped {scene.dropped()}")
        return scene, scene.datagrams()


@check("C-201", "40 to 1200 bytes: a header, then one FlatBuffer without file identifier or size prefix, encrypted, then its tag.")
def headers(subject):
    _, datagrams = run_of_samples(subject, 20)
    sizes = [len(data) for *_, data in datagrams]
    expect(all(40 <= size <= 1200 for size in sizes), f"{sizes}")
    for session, head, _, _ in datagrams:
        expect((head.magic, head.version, head.reserved, head.session) == (b"FW", 1, 0, session.number), f"a header has {vars(head)}")
    return f"{len(datagrams)} datagrams of {min(sizes)} to {max(sizes)} bytes, none dropped"


@check("C-202", "u64, counted from 1 by the sender for the session and this direction, never used again")
def packet_numbers(subject):
    with stage(subject, duration=300) as scene:
        scene.enough(60)
        numbers = [sealing.Head(datagram).packet for datagram in scene.server.arrived]
    expect(numbers[0] == 1 and len(set(numbers)) == len(numbers) and numbers == sorted(numbers), f"packet numbers {numbers[:30]}")
    return f"{len(numbers)} packet numbers from 1, none twice"


@check("C-203", "servo sample, counted by the client from 1, never used again in the session")
def indices(subject):
    _, datagrams = run_of_samples(subject)
    newest = [table.samples[0].index for _, _, table, _ in datagrams]
    expect(newest[0] == 1, f"the first index is {newest[0]}")
    expect(all(a < b for a, b in zip(newest, newest[1:])), f"newest indices {newest[:30]}")
    for _, _, table, _ in datagrams:
        one = [sample.index for sample in table.samples]
        expect(1 <= len(one) <= 9 and one == sorted(set(one), reverse=True), f"indices {one} in a datagram")
    return f"{len(newest)} datagrams, indices from 1, strictly falling in each"


@check("C-204", "A repeated sample is unchanged.")
def repeated(subject):
    _, datagrams = run_of_samples(subject)
    seen, again = {}, 0
    for _, _, table, _ in datagrams:
        for one in table.samples:
            again += one.index in seen
            expect(seen.setdefault(one.index, one) == one, f"sample {one.index} was {seen[one.index]}, then {one}")
    expect(again >= 2.5 * (len(datagrams) - 3), f"{again} repeated samples in {len(datagrams)} datagrams with redundancy 3")
    return f"{again} repeated samples are as before"


@check("C-205", "`previous` (u64): index of the sample that travelled before the oldest one here, 0 if there is none.")
def previous(subject):
    _, datagrams = run_of_samples(subject)
    travelled = []
    for _, _, table, _ in datagrams:
        travelled += sorted(one.index for one in table.samples if one.index not in travelled)
        before = [index for index in travelled if index < table.samples[-1].index]
        expect(table.previous == (max(before) if before else 0), f"previous {table.previous} before {table.samples[-1].index}")
    return f"the index before the oldest of {len(datagrams)} datagrams"


@check("C-206", "The suite is 1 (AES-256-GCM) where both CPUs have AES, else 2 (ChaCha20-Poly1305).")
def suites(subject):
    for suite in (1, 2):
        with stage(subject, suite=suite, duration=300) as scene:
            scene.enough(5)
            expect(not scene.dropped(), f"suite {suite}: the server dropped {scene.dropped()}")
    return "datagrams of both suites are opened"


@check("C-207", "of the tool, each axis within +-1000")
def numbers(subject):
    _, datagrams = run_of_samples(subject)
    for _, _, table, _ in datagrams:
        for one in table.samples:
            expect(finite(one) and all(abs(part) <= 1000 for part in one.position.values()), f"{one}")
    times = {one.index: one.client_time for _, _, table, _ in datagrams for one in table.samples}
    ordered = [times[index] for index in sorted(times)]
    expect(all(a < b for a, b in zip(ordered, ordered[1:])), "times that do not rise")
    return f"{len(times)} samples, finite, within 1000 m, with rising times"


@check("C-208", "`times` (32 bytes): how punctual the client is, only with a `report`, and in few of them (ours sends it twice a second).")
def reports(subject):
    _, datagrams = run_of_samples(subject)
    told = [table for _, _, table, _ in datagrams if table.report]
    expect(told and len(told) < len(datagrams), f"{len(told)} reports in {len(datagrams)} datagrams")
    expect(all(finite(table.report) for table in told), "a report that is not finite")
    alone = [table for _, _, table, _ in datagrams if table.times and not table.report]
    expect(not alone, f"{len(alone)} times without a report")
    return f"{len(told)} reports in {len(datagrams)} datagrams, finite; no times without one"
