#!/usr/bin/env python3
"""The dashboard shows something in each panel, and each alarm has its metric, on a server that has just started and was never joined.

A real server starts, and its /metrics is read once. Each metric that docs/grafana.json and docs/alerts.yml name must be there, so counters
at zero must be, too. With promtool, each expression of the dashboard must have a value for a server whose metrics stay like this.

usage: check_dashboard.py BIN_FOLDER SOURCE_FOLDER
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.request

PROGRAMS, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
PATIENCE = 60  # [s]


def expressions():
    """The expressions of the dashboard"""
    panels = json.loads((SOURCE / "docs/grafana.json").read_text())["panels"]
    return [target["expr"] for panel in panels for target in panel["targets"]]


def counters():
    """The text of /metrics of a server that has just started"""
    with tempfile.TemporaryDirectory() as folder:
        command = [PROGRAMS / "feltwire-server", "--scene", SOURCE / "scenes/room.json", "--port", "0", "--metrics", "0", "--state", folder]
        with subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
            try:
                for line in server.stdout:
                    if line.startswith("metrics: "):
                        with urllib.request.urlopen(line.split()[1], timeout=PATIENCE) as answer:
                            return answer.read().decode()
            finally:
                server.terminate()
    raise AssertionError("the server did not start")


def series(text):
    return [line.rsplit(" ", 1) for line in text.splitlines() if line and not line.startswith("#")]


class Dashboard(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.series = series(counters())
        cls.names = {name.partition("{")[0] for name, _ in cls.series}

    def test_each_metric_is_there(self):
        for file in ("grafana.json", "alerts.yml"):
            named = set(re.findall(r"\bfeltwire_[a-z_]+\b", (SOURCE / "docs" / file).read_text()))
            self.assertTrue(named)
            self.assertEqual(named - self.names, set(), file)

    def test_each_expression_has_a_value(self):
        promtool = shutil.which("promtool")
        if promtool is None:
            self.skipTest("no promtool (Debian's package prometheus)")
        tests = []
        for expression in expressions():
            expression = expression.replace("$__rate_interval", "1m")
            # NaN is no value: it differs from itself.
            tests.append({"expr": f"count(({expression}) == ({expression})) > bool 0", "eval_time": "5m",
                          "exp_samples": [{"labels": "{}", "value": 1}]})
        self.assertTrue(tests)
        inputs = [{"series": name, "values": f"{value}+0x40"} for name, value in self.series]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "tests.json"  # JSON is YAML.
            path.write_text(json.dumps({"evaluation_interval": "15s", "tests": [{"interval": "15s", "input_series": inputs,
                                                                               "promql_expr_test": tests}]}))
            done = subprocess.run([promtool, "test", "rules", str(path)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
