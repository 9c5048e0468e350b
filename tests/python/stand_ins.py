"""Stand-ins of torch, Isaac Lab and Gymnasium, for programs and tests on machines without them. test_adapters.py says which sources they follow."""
import abc
import sys
import types


def module(name, **contents):
    made = types.ModuleType(name)
    made.__dict__.update(contents)
    return made


class Tensor(list):
    """As much of torch.Tensor as the adapter uses."""

    shape = property(lambda self: (len(self), 3))

    def detach(self):
        return self

    def cpu(self):
        return self

    def reshape(self, *_):
        return self

    def tolist(self):
        return list(self)


def isaac():
    """{name: module} of Isaac Lab and torch."""
    class DeviceBase(abc.ABC):
        def __init__(self, retargeters=None):
            self._retargeters = retargeters or []

        @abc.abstractmethod
        def reset(self):
            raise NotImplementedError

        @abc.abstractmethod
        def add_callback(self, key, func):
            raise NotImplementedError

        def _get_raw_data(self):
            raise NotImplementedError

        def advance(self):
            raise NotImplementedError

    return {"isaaclab": module("isaaclab"), "isaaclab.devices": module("isaaclab.devices", DeviceBase=DeviceBase),
            "torch": module("torch", float32="float32", tensor=lambda values, dtype=None, device=None: Tensor(values),
                            cat=lambda parts, dim: Tensor(one for part in parts for one in part))}


def gymnasium():
    """{name: module} of Gymnasium. Its make() gives a table, whatever the name."""
    class Env:
        metadata = {"render_modes": []}

        def reset(self, *, seed=None, options=None):
            raise NotImplementedError

        def close(self):
            pass

        @property
        def unwrapped(self):
            return self

    class Wrapper(Env):
        def __init__(self, env):
            assert isinstance(env, Env)
            self.env = env

        @property
        def unwrapped(self):
            return self.env.unwrapped

    class Table(Env):
        """A table at z = 0; the environment's own state is the number of its steps."""
        steps = 0
        closed = False

        def step(self, action):
            self.steps += 1
            return action, 0.0, False, False, {"steps": self.steps}

        def reset(self, *, seed=None, options=None):
            self.steps = 0
            return seed, {"options": options}

        def close(self):
            self.closed = True

    return {"gymnasium": module("gymnasium", Wrapper=Wrapper, Env=Env, make=lambda _: Table())}


def put(*interfaces):
    """For the rest of this program."""
    for modules in interfaces:
        sys.modules.update(modules)
