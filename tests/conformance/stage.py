"""One client and the model server that it talks to: what a check of a client looks at."""
import contextlib
import time

import patience
from checks import TIMED_OUT, Failure
from model_server import ModelServer


@contextlib.contextmanager
def stage(subject, *options, server=None, start=True, wrong=(), silence=20.0, suite=None, answer=None, grant=None, **more):
    """Starts a server and a client; ends both."""
    server = server or ModelServer(wrong, silence, suite, roles=("operator",))
    if answer:
        server.answer = answer
    if grant:
        server.grant = grant
    scene = Stage(server)
    try:
        if start:
            scene.run = subject.start(server, *options, **more)
        yield scene
    finally:
        if scene.run:
            scene.run.stop()
        server.close()


class Stage:
    def __init__(self, server):
        self.server, self.run = server, None

    def until(self, condition, what):
        """Waits for a condition, or for the end of the client."""
        end = time.monotonic() + patience.LONGEST
        while True:
            ended = self.run.process.poll() is not None
            value = condition()
            if value:
                return value
            if ended:
                raise Failure(f"the client ended before {what}: {self.run.wait()[1].strip()[-300:]}")
            if time.monotonic() > end:
                raise Failure(f"{TIMED_OUT} {patience.LONGEST} s: {what}")
            time.sleep(0.005)

    def requests(self, name):
        return [value for _, kind, value, _ in list(self.server.requests) if kind == name]

    def datagrams(self, kind=1, session=None):
        """(session, head, table, bytes) of what came so far."""
        return [(one[1], *one[2:]) for one in list(self.server.datagrams)
                if one[2].kind == kind and (session is None or one[1].number == session)]

    def samples(self, session=None):
        """The samples by rising index: (index, client's time [s], held elastic force x, y, z)."""
        found = {}
        for _, _, table, _ in self.datagrams(1, session):
            for one in table.samples:
                held = one.held_elastic
                found.setdefault(one.index, (one.index, one.client_time / 1e9, (held.x, held.y, held.z)))
        return [found[index] for index in sorted(found)]

    def enough(self, count):
        """Waits for so many datagrams, taken or dropped."""
        self.until(lambda: len(self.server.arrived) >= count, f"{count} datagrams came")

    def dropped(self):
        return {name: value for name, value in self.server.counts.items() if name.startswith("dropped")}


def plain(force):
    """An answer with this force to every sample."""
    return lambda session, table: {"force": force}
