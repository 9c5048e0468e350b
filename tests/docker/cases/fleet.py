"""docker/fleet.yml as it is shipped. Hands join through each of the hosts. The host that serves the room is killed together with the NATS
server that leads the directory: its hands feel again at another host. Then the whole directory is gone: sessions go on, a hand joins, and
a host is killed once more."""

import collections
import json
import re
import ssl
import time
import urllib.request

import composition
from composition import engine, wait_until
from judge import Recording, expect_passive, report

FILE = composition.ROOT / "docker/fleet.yml"
NATS = ["n1", "n2", "n3"]
HOSTS = ["host-a", "host-b", "host-c", "host-d"]
HANDS = {"hand-a": "room", "hand-b": "room", "hand-c": "plane", "hand-d": "plane"}
LATE = "hand-late"  # joins while there is no directory
HOLD_TIME = 0.5  # [s]
PATIENT = {"FELTWIRE_CLIENT_HOLD_TIME": f"{HOLD_TIME:g}"}
FELT = 0.1  # [N]
PATIENCE = 180  # [s] that something may take on a busy machine
# The bar for a hand of a host that dies. The machine of a test may be slower, so it is told and not judged.
BAR = 5.0  # [s]


def further_services():
    """What the test adds to the file: a recording for each hand, and a hand that comes late. On a busy machine a hand may stand still for
    longer than a device with a motor may hold its force; a simulated one harms nobody."""
    services = {name: {"environment": {"FELTWIRE_CLIENT_RECORD": f"/reports/{name}.csv", **PATIENT}} for name in HANDS}
    services[LATE] = {
        "image": composition.IMAGE, "read_only": True, "cap_drop": ["ALL"], "networks": ["hands"],
        "volumes": ["clients:/clients:ro", "${FELTWIRE_FLEET_REPORTS}:/reports"],
        "environment": {"FELTWIRE_CONNECT": "${FELTWIRE_LATE_HOST:-host-a}:6720", "FELTWIRE_CA": "/clients/ca.pem",
                        "FELTWIRE_TOKEN_FILE": "/clients/hands.token", **PATIENT},
        "command": ["feltwire-client", "--scene", "room", "--name", LATE, "--device", "simulated:path=taps,frequency=1,depth=0.001,seed=5",
                    "--report", f"/reports/{LATE}.json", "--record", f"/reports/{LATE}.csv"]}
    return {"services": services}


def status(compose, host):
    """`feltwire-server fleet status` at a host: (hosts: state and hands, scenes: owner and standby). Empty while the directory is silent."""
    told = engine("exec", compose.container(host), "feltwire-server", "fleet", "status", check=False)
    hosts = {name: (state, int(hands)) for name, state, hands in re.findall(r"^(host-\w)\s+(\w+)\s+\S+:\d+\s+(\d+) ", told, re.M)}
    scenes = {name: (owner, standby) for name, owner, standby in re.findall(r"^(room|plane)\s+(host-\w(?: \(gone\))?)\s+\d+\s+(\S+)$", told, re.M)}
    return hosts, scenes


def leader(compose, bucket, asked):
    """The NATS server that takes the writes of a bucket."""
    answer = engine("exec", compose.container(asked), "bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/8222; "
                    r"printf 'GET /jsz?accounts=true&streams=true HTTP/1.0\r\n\r\n' >&3; cat <&3")
    told = json.loads(answer[answer.index("{"):])
    return next((stream["cluster"].get("leader") for account in told["account_details"] for stream in account["stream_detail"]
                 if stream["name"] == f"KV_{bucket}"), None)


def page(compose, path):
    """What the gateway's page answers, over HTTPS."""
    place = engine("port", compose.container("gateway"), "6760/tcp").splitlines()[0]
    trust = ssl.create_default_context()
    trust.check_hostname, trust.verify_mode = False, ssl.CERT_NONE
    with urllib.request.urlopen(f"https://{place}{path}", context=trust, timeout=10) as answer:
        return answer.read().decode()


def joins(compose):
    """How many sessions the hosts' logs tell of, by the name of the hand. The gateway has one for each scene."""
    logs = "".join(compose.logs(name) for name in HOSTS)
    return collections.Counter(re.findall(r"\] (\S+) \(.*\) joined scene", logs))


class Hand:
    """A hand's report and recording, at times of the engine's clock."""

    def __init__(self, compose, name):
        self.told = report(compose.out / f"{name}.json")
        self.recording = Recording(compose.out / f"{name}.csv")
        self.begin = compose.ended_at(name) - self.recording.t[-1]

    def rows_from(self, time):
        return range(self.recording.after(time - self.begin), len(self.recording.t))

    def felt_again(self, killed):
        """[s] from the death of its host until it has a session, and until it holds a force; None where it does not."""
        begin = killed + 1.5 * HOLD_TIME  # until then the force of the last answer fades
        rows = self.rows_from(begin)
        session = next((i for i in rows if 0.0 < self.recording.age[i] < HOLD_TIME), None)
        force = next((i for i in rows if session is not None and i >= session and self.recording.held[i] > FELT), None)
        return tuple(None if i is None else round(self.recording.t[i] + self.begin - killed, 2) for i in (session, force))

    def most_held(self, begin, end):
        return self.recording.most_held(begin - self.begin, end - self.begin)


def all_live(compose, asked, scenes=("room", "plane")):
    """Every host lives, and every scene has an owner and a standby that live."""
    hosts, owned = status(compose, asked)
    living = [name for name in HOSTS if hosts.get(name, ("",))[0] == "lives"]
    return living == HOSTS and all(set(owned.get(scene, ("",))) <= set(HOSTS) for scene in scenes) and owned


class Story:
    """What happened: how often each hand lost its session, when hosts died, and when there was no directory."""

    def __init__(self, compose, judge):
        self.compose, self.judge = compose, judge
        self.lost = dict.fromkeys(HANDS, 0)
        self.deaths = {name: [] for name in HANDS}
        self.owned = {}
        self.without_directory = (0.0, 0.0)

    def await_hands(self, when):
        """Every hand has as many sessions as it must have had, and the gateway at least these."""
        def there():
            had = joins(self.compose)
            return all(had[name] == 1 + lost for name, lost in self.lost.items())
        wait_until(f"all hands {when}", there, PATIENCE)

    def await_hosts(self, asked, when):
        self.owned = wait_until(f"all hosts to live {when}", lambda: all_live(self.compose, asked), PATIENCE)
        self.judge.measured(f"{when}: served by, standby", self.owned)

    def kill_owner(self, *with_it):
        """Kills the host of the room, and others in the same moment. Its name."""
        host = self.owned["room"][0]
        engine("kill", *(self.compose.container(name) for name in (host, *with_it)))
        for name, deaths in self.deaths.items():
            if self.owned[HANDS.get(name, "room")][0] == host:
                self.lost[name] += 1
                deaths.append(self.compose.ended_at(host))
        return host

    def host_and_leader_die(self):
        lead = leader(self.compose, "feltwire_scenes", NATS[0])
        self.judge.expect("the directory has a leader", lead in NATS, equal=True)
        standby = self.owned["room"][1]
        host = self.kill_owner(lead)
        self.await_hands("at another host")
        alive = next(name for name in HOSTS if name != host)
        # The standby serves first, and tells the directory later.
        owner = wait_until("the directory to know", lambda: (owner := status(self.compose, alive)[1].get("room", ("",))[0]) in HOSTS and owner != host and owner, PATIENCE)
        self.judge.expect("the room's host is the former standby", owner, equal=standby)
        engine("start", self.compose.container(lead), self.compose.container(host))
        self.await_hosts(alive, "after the first death")

    def directory_is_gone(self, call):
        engine("kill", *(self.compose.container(name) for name in NATS))
        begin = time.time()
        time.sleep(8.0)  # longer than a host may be silent
        # It asks a host that does not serve the room.
        call("up", "-d", "--no-build", "--no-deps", LATE)
        self.lost[LATE], self.deaths[LATE] = 0, []
        self.await_hands("without a directory")
        time.sleep(3.0)
        self.without_directory = (begin, time.time())
        host = self.kill_owner()
        self.await_hands("at another host, without a directory")
        time.sleep(3.0)
        engine("start", *(self.compose.container(name) for name in (*NATS, host)))
        self.await_hosts(host, "after the second death")


def play(compose, judge, call):
    call("up", "-d", "--no-build", "gateway", *HANDS)
    story = Story(compose, judge)
    story.await_hosts(HOSTS[0], "at first")
    story.await_hands("at first")
    judge.expect("the gateway's page", page(compose, "/ready"), equal="ok\n")
    time.sleep(4.0)
    story.host_and_leader_die()
    time.sleep(4.0)
    further = next(name for name in HOSTS if name != story.owned["room"][0])
    story.directory_is_gone(compose_with(compose, FELTWIRE_LATE_HOST=further))
    looks = len(re.findall("scene room: looks on", compose.logs("gateway")))
    judge.expect("sessions of the gateway in the room", looks, equal=3)
    return story


def compose_with(compose, **environment):
    return composition.caller(compose.project, FILE, compose.file, timeout=600, FELTWIRE_FLEET_REPORTS=str(compose.out),
                              FELTWIRE_FLEET_PAGE="0", **environment)


def judge_hand(judge, story, name, hand, exit_code):
    judge.expect(f"{name}: exit code", exit_code, equal=0)
    expect_passive(judge, name, hand.told, hand.recording)
    judge.expect(f"{name}: sessions lost", hand.told["disconnections"], equal=story.lost[name])
    judge.expect(f"{name}: sessions found again", hand.told["reconnections"], equal=story.lost[name])
    if name != LATE:
        judge.expect(f"{name}: largest force without a directory [N]", hand.most_held(*story.without_directory), at_least=FELT)
    for death in story.deaths[name]:
        session, force = hand.felt_again(death)
        judge.expect(f"{name}: feels after its host has died", force is not None, equal=True)
        judge.measured(f"{name}: session and force after its host's death [s] (bar: {BAR:g})", (session, force))


def run(compose, judge):
    compose.file.write_text(json.dumps(further_services(), indent=1))
    call = compose_with(compose)
    try:
        story = play(compose, judge, call)
        ended = compose.stop(*story.lost)
        for name in story.lost:
            judge_hand(judge, story, name, Hand(compose, name), ended[name][0])
    finally:
        (compose.folder / "compose.log").write_text(call("logs", "--no-color"))
        call("down", "-t", "0", "--volumes")
