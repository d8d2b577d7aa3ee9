"""Drives over a local Ray cluster of two workers, held against the program on one machine: FINGERPOST names the program."""

import inspect
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pyarrow.parquet
import pytest
import ray
from ray.cluster_utils import Cluster

import fingerpost
from fingerpost import fleet

PROGRAM = os.environ["FINGERPOST"]
DRIVES = 12
#: Small pictures and few of them, so that a drive takes seconds.
SMALL = {"size": (120, 90), "fps": 4.0, "conditions": ("clear", "unmarked")}
TOWN = pathlib.Path(__file__).parents[2] / "crates/fingerpost-sim/assets"
#: What is made of a drive by the fleet, beside what the program wrote of it.
OF_THE_FLEET = {"id", "size", "fps", "map", "controller", "fault", "program", "error"}

JOB = """
import os, sys, ray
from fingerpost import fleet
ray.init(address=sys.argv[1], log_to_driver=False)
fleet.campaign({drives}, sys.argv[2], size=(120, 90), fps=4.0, conditions=("clear", "unmarked"), program=os.environ["FINGERPOST"])
"""


def call(*words):
    return subprocess.run([PROGRAM, *map(str, words)], check=True, capture_output=True, text=True)


@pytest.fixture(scope="module")
def cluster():
    """A head without processor cores, and two workers of one core each."""
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    cluster.workers = [cluster.add_node(num_cpus=1) for _ in range(2)]
    ray.init(address=cluster.address, log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture(scope="module")
def on_one_machine(tmp_path_factory):
    """What the program's own campaign writes of the same drives."""
    out = tmp_path_factory.mktemp("one") / "campaign"
    call("campaign", "--drives", DRIVES, "--size", "120x90", "--fps", 4, "--conditions", "clear,unmarked", "--out", out)
    return json.loads((out / "campaign.json").read_text())["drives"]


def results(out):
    return sorted((out / "drives").glob("*.json"))


def wait_for(condition):
    deadline = time.monotonic() + 600
    while not condition():
        assert time.monotonic() < deadline, "the fleet does not come to what is waited for"
        time.sleep(0.1)


def test_a_killed_job_and_a_killed_worker_cost_no_result(cluster, on_one_machine, tmp_path):
    out = tmp_path / "out"
    # The whole job is killed when a few drives are done.
    job = subprocess.Popen([sys.executable, "-c", JOB.format(drives=DRIVES), cluster.address, str(out)], stderr=subprocess.PIPE)
    wait_for(lambda: len(results(out)) >= 3 or job.poll() is not None)
    assert job.poll() is None, job.stderr.read().decode()
    job.send_signal(signal.SIGKILL)
    job.wait()
    before = {path: path.stat().st_mtime_ns for path in results(out)}
    assert 3 <= len(before) < DRIVES and not (out / "results.parquet").exists()

    # The same call goes on, and a worker is killed with all its processes.
    def kill():
        wait_for(lambda: len(results(out)) >= len(before) + 4)
        cluster.remove_node(cluster.workers.pop(), allow_graceful=False)
        killed.append(len(results(out)))

    killed = []
    killer = threading.Thread(target=kill)
    killer.start()
    table = fleet.campaign(DRIVES, out, **SMALL, program=PROGRAM)
    killer.join()
    assert killed and killed[0] < DRIVES, "all was done before the worker was killed"
    # Ray hears of a worker's end by its lost connection, which may be after the last result.
    wait_for(lambda: len([node for node in ray.nodes() if node["Alive"]]) == 2)

    assert {path: path.stat().st_mtime_ns for path in before} == before, "what was done is done again"
    assert len(results(out)) == table.num_rows == DRIVES
    rows = table.to_pylist()
    assert [row["error"] for row in rows] == [None] * DRIVES
    ours = [{name: value for name, value in row.items() if name not in OF_THE_FLEET} for row in rows]
    assert ours == sorted(on_one_machine, key=lambda drive: drive["seed"])
    assert sum(row["features_detected"] for row in rows) > DRIVES
    assert pyarrow.parquet.read_table(out / "results.parquet").equals(table)


def killer(folder, condition):
    """A program that kills the worker that starts it, where a condition of the shell holds, and else does what the program does."""
    program = folder / "killer"
    program.write_text(f'#!/bin/sh\nif [ "$1" = tether ] && {condition}; then kill -9 "$2"; fi\nexec {PROGRAM} "$@"\n')
    program.chmod(0o755)
    return program


def test_a_drive_whose_worker_dies_is_tried_again(cluster, tmp_path):
    drives = fleet.campaign_drives(1, **SMALL)
    once = killer(tmp_path, f"mkdir {tmp_path}/seen 2>/dev/null")
    rows = fleet.run(drives, tmp_path / "once", program=once).to_pylist()
    assert (tmp_path / "seen").exists() and rows[0]["error"] is None and rows[0]["frames"] > 0
    # One that always dies fails alone, and is not taken for a refusal of settings.
    always = killer(tmp_path, "true")
    with pytest.raises(fleet.FleetError, match=r"(?s)1 of 1 drives failed.*its worker died, and that of 1 more tries.*call again"):
        fleet.run(drives, tmp_path / "always", program=always, retries=1)
    assert pyarrow.parquet.read_table(tmp_path / "always/results.parquet")["program"].to_pylist() == [None]
    with pytest.raises(fleet.FleetError, match="says nothing of the settings"):
        fleet.tune(drives, tmp_path / "tuned", keys={"track.detect_present": (0.6, 0.9)}, population=2, trials=2, program=always, retries=0)


def test_recorded_drives_give_what_run_gives(cluster, tmp_path):
    drive, run = tmp_path / "drive", tmp_path / "run"
    call("simulate", "--map", TOWN / "town.osm", "--route", TOWN / "town_route.geojson", "--frames", 20, "--size", "160x120", "--out", drive)
    named = {"camera": drive / "camera.toml", "route": drive / "route.geojson", "start_m": 0.0, "truth": drive / "truth.jsonl"}
    call("run", drive, "--camera", named["camera"], "--route", named["route"], "--start-m", 0, "--truth", named["truth"], "--out", run)
    good = fleet.RecordedDrive(input=drive, **named)
    bad = fleet.RecordedDrive(input=tmp_path / "nowhere", **named)
    with pytest.raises(fleet.FleetError, match=r"(?s)1 of 2 drives failed.*nowhere.*the same call"):
        fleet.run([bad, good], tmp_path / "out", keep=["frames.jsonl"], program=PROGRAM)
    rows = pyarrow.parquet.read_table(tmp_path / "out/results.parquet").to_pylist()
    assert "nowhere" in rows[0]["error"] and rows[1]["error"] is None
    expected = json.loads((run / "summary.json").read_text())
    of_the_machine = {"fps", "stage_ms"}
    assert {name: rows[1][name] for name in expected.keys() - of_the_machine} == {
        name: value for name, value in expected.items() if name not in of_the_machine
    }
    kept = (tmp_path / "out/files" / rows[1]["id"] / "frames.jsonl").read_text().splitlines()
    plain = [{**json.loads(line), "stage_ms": {}} for line in kept]
    assert plain == [{**json.loads(line), "stage_ms": {}} for line in (run / "frames.jsonl").read_text().splitlines()]


def test_a_search_gives_the_same_front_again(cluster, tmp_path):
    drives = fleet.campaign_drives(2, **SMALL)
    search = {"keys": {"track.detect_present": (0.6, 0.9), "road_surface.bank.frames": (1, 6)}, "trials": 4, "population": 3, "program": PROGRAM}
    found = fleet.tune(drives, tmp_path / "tuned", held_out=fleet.campaign_drives(1, seed=9, **SMALL), **search)
    rows = found.to_pylist()
    assert [row["trial"] for row in rows] == list(range(4))
    # The first trial is today's settings, so that a campaign finds the same.
    campaign = fleet.run(drives, tmp_path / "campaign", program=PROGRAM).to_pylist()
    features, detected = (sum(row[name] for row in campaign) for name in ("features_total", "features_detected"))
    assert rows[0]["missed"] == 1 - detected / features
    defaults = fingerpost.config_schema()["properties"]["track"]["properties"]
    assert rows[0]["track.detect_present"] == defaults["detect_present"]["default"]
    assert isinstance(rows[1]["road_surface.bank.frames"], int)
    # No trial of the front is beaten by another, and each has its configuration and what came of the drives held out.
    scores = [tuple(row[name] if row[name] is not None else float("inf") for name in ("missed", "false", "error_p95_m")) for row in rows]
    for row, score in zip(rows, scores, strict=True):
        beaten = any(other != score and all(a <= b for a, b in zip(other, score, strict=True)) for other in scores)
        assert row["front"] == (not beaten)
        assert (tmp_path / f"tuned/{row['trial']}.toml").exists() == row["front"]
        assert (row["held_out_missed"] is not None) == (row["front"] or row["trial"] == 0)
    # What is recorded is played back: the same call does nothing and gives the same, a longer search begins with it.
    done = {path: path.stat().st_mtime_ns for path in results(tmp_path / "tuned")}
    assert fleet.tune(drives, tmp_path / "tuned", held_out=fleet.campaign_drives(1, seed=9, **SMALL), **search).equals(found)
    assert {path: path.stat().st_mtime_ns for path in results(tmp_path / "tuned")} == done


def test_a_drive_in_closed_loop_is_one_result_for_each_controller(cluster, tmp_path):
    options = {"size": (120, 90), "fps": 2.0, "conditions": ["clear"], "controllers": ["fuzzy", "stanley"]}
    rows = fleet.campaign(1, tmp_path / "out", seed=3, program=PROGRAM, **options).to_pylist()
    assert [row["controller"] for row in rows] == ["fuzzy", "stanley"]
    assert all(row["end"] and row["frames"] > 0 for row in rows)


def test_mistakes_say_what_to_do(cluster, tmp_path):
    drives = fleet.campaign_drives(1, **SMALL)
    with pytest.raises(fleet.FleetError, match=r"cannot run the program.*install it there"):
        fleet.run(drives, tmp_path / "out", program="/nowhere/fingerpost")
    with pytest.raises(fleet.FleetError, match=r"(?s)1 of 1 drives failed.*sunny"):
        fleet.run([fleet.SimulatedDrive(seed=1, conditions="sunny")], tmp_path / "out", program=PROGRAM)
    with pytest.raises(fleet.FleetError, match="no drives"):
        fleet.run([], tmp_path / "out", program=PROGRAM)
    with pytest.raises(fleet.FleetError, match="campaign and closed loop have different results"):
        fleet.run([*drives, fleet.SimulatedDrive(seed=1, controller="fuzzy")], tmp_path / "out", program=PROGRAM)
    with pytest.raises(fingerpost.ConfigError, match=r"track\.nothing: there is no number.*config_schema"):
        fleet.tune(drives, tmp_path / "out", keys={"track.nothing": (0.1, 0.2)}, program=PROGRAM)
    with pytest.raises(fingerpost.ConfigError, match="reaches beyond"):
        fleet.tune(drives, tmp_path / "out", keys={"track.detect_present": (0.5, 1.5)}, program=PROGRAM)
    with pytest.raises(fingerpost.ConfigError, match="the lesser first"):
        fleet.tune(drives, tmp_path / "out", keys={"track.detect_present": (0.9, 0.5)}, program=PROGRAM)
    assert issubclass(fleet.FleetError, fingerpost.FingerpostError)


def test_everything_public_has_words_and_types():
    for name in fleet.__all__:
        value = getattr(fleet, name)
        if callable(value):
            assert inspect.getdoc(value), f"{name} has no words"
    for function in (fleet.campaign, fleet.campaign_drives, fleet.run, fleet.tune):
        signature = inspect.signature(function)
        assert signature.return_annotation is not inspect.Signature.empty
        assert all(parameter.annotation is not inspect.Parameter.empty for parameter in signature.parameters.values())
