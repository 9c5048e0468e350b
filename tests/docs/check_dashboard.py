#!/usr/bin/env python3
"""The dashboard shows something in each panel, and each alarm has its metric, on a server that has just started and was never joined.

A real server starts, and its /metrics is read once. Each metric that docs/grafana.json and docs/alerts.yml name must be there, so counters
at zero must be, too. With promtool, each expression of the dashboard must have a value for a server whose metrics stay like this. Prometheus
takes the configurations of docs/operations.md, and the counters are read over HTTPS as the second one says.

usage: check_dashboard.py BIN_FOLDER SOURCE_FOLDER
"""

import contextlib
import json
import pathlib
import re
import shutil
import ssl
import subprocess
import sys
import tempfile
import unittest
import urllib.error
import urllib.request

PROGRAMS, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
PATIENCE = 60  # [s]


def expressions():
    """The expressions of the dashboard"""
    panels = json.loads((SOURCE / "docs/grafana.json").read_text())["panels"]
    return [target["expr"] for panel in panels for target in panel["targets"]]


@contextlib.contextmanager
def served(address):
    """Starts a server whose counters are at this address. Gives its address of /metrics and its state folder."""
    with tempfile.TemporaryDirectory() as folder:
        command = [PROGRAMS / "feltwire-server", "--scene", SOURCE / "scenes/room.json", "--port", "0", "--metrics", address, "--state", folder]
        with subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
            try:
                line = next((line for line in server.stdout if line.startswith("metrics: ")), None)
                if line is None:
                    raise AssertionError("the server did not start")
                yield line.split()[1], pathlib.Path(folder)
            finally:
                server.terminate()


def counters():
    """The text of /metrics of a server that has just started"""
    with served("0") as (url, _), urllib.request.urlopen(url, timeout=PATIENCE) as answer:
        return answer.read().decode()


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


class Scrape(unittest.TestCase):
    def test_prometheus_takes_the_examples(self):
        promtool = shutil.which("promtool")
        if promtool is None:
            self.skipTest("no promtool (Debian's package prometheus)")
        text = (SOURCE / "docs/operations.md").read_text()
        examples = [block for block in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL) if "scrape_configs" in block]
        self.assertEqual([("https" in example) for example in examples], [False, True])
        for example in examples:
            with tempfile.TemporaryDirectory() as folder:
                shutil.copy(SOURCE / "docs/alerts.yml", folder)
                for path in re.findall(r"/etc/prometheus/(\S+)", example):
                    (pathlib.Path(folder) / path).touch()
                config = pathlib.Path(folder) / "prometheus.yml"
                config.write_text(example.replace("/etc/prometheus", folder))
                done = subprocess.run([promtool, "check", "config", str(config)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout)

    def test_beyond_this_machine_with_the_certificate_and_a_token(self):
        with served("0.0.0.0:0") as (url, state):
            self.assertTrue(url.startswith("https://"), url)
            trusted = ssl.create_default_context(cafile=str(state / "certificate.pem"))
            request = urllib.request.Request(url.replace("127.0.0.1", "localhost"))
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(request, timeout=PATIENCE, context=trusted)
            self.assertEqual(refused.exception.code, 401)
            refused.exception.close()
            request.add_header("Authorization", "Bearer " + (state / "local.token").read_text().strip())
            with urllib.request.urlopen(request, timeout=PATIENCE, context=trusted) as answer:
                self.assertIn("feltwire_sessions", answer.read().decode())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
