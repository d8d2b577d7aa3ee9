"""The package against the program: FINGERPOST names the program, and a simulated drive is run by both."""

import inspect
import json
import os
import pathlib
import subprocess
import threading
import time

import numpy
import pytest

import fingerpost

PROGRAM = os.environ["FINGERPOST"]
# From the first junction's being far ahead to its being passed.
FRAMES = 60


def call(*words):
    return subprocess.run([PROGRAM, *map(str, words)], check=True, capture_output=True, text=True)


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def pixels(path):
    magic, size, most, rest = path.read_bytes().split(b"\n", 3)
    assert (magic, most) == (b"P6", b"255")
    width, height = map(int, size.split())
    return numpy.frombuffer(rest, numpy.uint8).reshape(height, width, 3)


@pytest.fixture(scope="session")
def town(tmp_path_factory):
    """The demonstration's route and camera as files, and the drive and run of the program on them."""
    folder = tmp_path_factory.mktemp("town")
    _, route = fingerpost.demo_town()
    (folder / "route.geojson").write_text(route.to_geojson())
    roads = pathlib.Path(__file__).parents[2] / "crates/fingerpost-sim/assets/town.osm"
    call("simulate", "--map", roads, "--route", folder / "route.geojson", "--frames", FRAMES, "--size", "640x480", "--ppm",
         "--out", folder / "drive")
    call("run", folder / "drive", "--camera", folder / "drive/camera.toml", "--route", folder / "route.geojson", "--start-m", 0,
         "--map", roads, "--near", "47.21782,9.53963", "--truth", folder / "drive/truth.jsonl", "--no-recording", "--out", folder / "run")
    return folder


def test_frames_are_those_of_the_program(town):
    camera = fingerpost.Camera.from_file(town / "drive/camera.toml")
    route = fingerpost.Route.from_file(town / "route.geojson")
    roads, _ = fingerpost.demo_town()
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0, roads=roads, near=(47.21782, 9.53963))
    times = [float(line) for line in (town / "drive/times.txt").read_text().split()]
    records = []
    for i, t_s in enumerate(times):
        output = pipeline.step(pixels(town / f"drive/frames/{i:06}.ppm"), t_s=t_s)
        records.append(output.record)
        assert output.why == output.record["why"] and output.state == output.record["state"]
    expected = lines(town / "run/frames.jsonl")
    for record in expected:
        record["stage_ms"] = {}
    assert records == expected
    assert any(record["state"] == "tracking" for record in records), "nothing was followed"
    assert pipeline.frames == len(records)

    summary = json.loads((town / "run/summary.json").read_text())
    evaluation = fingerpost.evaluate_junctions(records, lines(town / "drive/truth.jsonl"), route)
    for key in ("features_total", "features_detected", "false_detections", "arrivals", "position_error_m", "motion_error_pct"):
        assert evaluation[key] == summary[key], key
    lanes = fingerpost.evaluate_lanes(records, lines(town / "drive/truth.jsonl"), (640, 480))
    assert lanes


def test_simulated_frames_are_those_of_the_program(town):
    roads, route = fingerpost.demo_town()
    camera = fingerpost.Camera.from_file(town / "drive/camera.toml")
    drive = fingerpost.Simulator(roads, route, camera, seed=1, frames=FRAMES)
    assert len(drive) == FRAMES
    for i in (0, 7, FRAMES - 1):
        assert numpy.array_equal(drive[i].picture, pixels(town / f"drive/frames/{i:06}.ppm"))
        assert drive[i].truth == lines(town / "drive/truth.jsonl")[i]
    assert numpy.array_equal(drive[-1].picture, drive[FRAMES - 1].picture)
    assert set(numpy.unique(drive[0].road_mask)) <= {0, 255}
    with pytest.raises(IndexError):
        drive[FRAMES]


def scene():
    roads, route = fingerpost.demo_town()
    camera = fingerpost.Camera(320, 240, fx=210, fy=210, cx=159.5, cy=119.5, height_m=1.5, pitch_deg=8, x_m=1.5)
    return roads, route, camera, fingerpost.Simulator(roads, route, camera, frames=12)


def test_evidence_is_the_view_from_above_and_the_callers_own():
    _, route, camera, drive = scene()
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
    first = pipeline.step(drive[0].picture, t_s=0.0)
    ground, kept = first.ground_view, first.road_surface.copy()
    assert ground.dtype == numpy.uint8 and ground.ndim == 3 and ground.shape[2] == 3
    assert first.road_surface.shape == first.ground_validity.shape == first.road_known.shape == ground.shape[:2]
    # The road lies right ahead of the vehicle, and the corners beside it are not seen.
    rows, columns = ground.shape[:2]
    assert first.road_surface[rows * 3 // 4, columns // 2] > 128
    assert first.ground_validity[rows // 2, columns // 2] == 1 and first.ground_validity[-1, 0] == 0
    # A pixel of the view from above has the colour of the place in the picture, by the documented formula.
    settings = fingerpost.config_schema()["properties"]["ground_view"]["properties"]
    scale, far, half = (settings[key]["default"] for key in ("metres_per_pixel", "far_m", "half_width_m"))
    row, column = rows * 2 // 3, columns // 2 + 5
    u, v = camera.pixel_of_ground(far - (row + 0.5) * scale, half - (column + 0.5) * scale)
    shown = drive[0].picture[round(v) - 1:round(v) + 2, round(u) - 1:round(u) + 2].reshape(-1, 3).astype(int)
    assert (shown.min(0) - 2 <= ground[row, column]).all() and (ground[row, column] <= shown.max(0) + 2).all()
    for i in range(1, 12):
        pipeline.step(drive[i].picture, t_s=0.1 * i)
    assert numpy.array_equal(first.road_surface, kept)


def test_views_with_gaps_are_frames_too():
    _, route, camera, drive = scene()
    plain, cut = (fingerpost.Pipeline(camera, route, start_m=0.0) for _ in range(2))
    for i in range(3):
        picture = drive[i].picture
        wide = numpy.zeros((480, 320, 6), numpy.uint8)
        wide[::2, :, ::2] = picture
        view = wide[::2, :, ::2]
        assert not view.flags["C_CONTIGUOUS"]
        assert plain.step(picture, t_s=0.1 * i).record == cut.step(view, t_s=0.1 * i).record


def test_mistakes_say_what_to_do():
    roads, route, camera, drive = scene()
    pipeline = fingerpost.Pipeline(camera, route)
    before = pipeline.frames
    with pytest.raises(fingerpost.FrameError, match=r"\[120, 320, 3\].*\[240, 320, 3\].*scaled_to"):
        pipeline.step(drive[0].picture[::2], t_s=0.0)
    with pytest.raises(fingerpost.FrameError, match="finite"):
        pipeline.step(drive[0].picture, t_s=float("nan"))
    with pytest.raises(TypeError):
        pipeline.step(drive[0].picture.astype(numpy.float32))
    assert pipeline.frames == before
    with pytest.raises(fingerpost.ConfigError, match="metres_per_pixel"):
        fingerpost.Pipeline(camera, config="[ground_view]\nmetres_per_pixel = -1.0\n")
    with pytest.raises(fingerpost.ConfigError, match="unknown field"):
        fingerpost.Pipeline(camera, config="[ground_view]\nfarr_m = 1.0\n")
    with pytest.raises(fingerpost.CameraError, match="check the path"):
        fingerpost.Camera.from_file("nowhere/camera.toml")
    with pytest.raises(fingerpost.CameraError, match="kannala-brandt"):
        fingerpost.Camera(320, 240, fx=210, fy=210, cx=159.5, cy=119.5, height_m=1.5, distortion="fisheye")
    with pytest.raises(fingerpost.MapError):
        roads.plan([(47.2178, 9.5397)])
    with pytest.raises(fingerpost.MapError, match="latitude|degrees"):
        roads.plan([(470.0, 9.5), (47.2, 9.5)])
    with pytest.raises(fingerpost.SimulationError, match="sunny"):
        fingerpost.Simulator(roads, route, camera, conditions="sunny")
    with pytest.raises(fingerpost.EvaluationError, match="frame 0"):
        fingerpost.evaluate_junctions([{"frame": "one"}], [], route)
    assert issubclass(fingerpost.FrameError, fingerpost.FingerpostError)


def test_the_interpreters_lock_is_released_in_a_step():
    _, route, camera, drive = scene()
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
    pictures = [drive[i].picture for i in range(12)]
    # A step begins another thread's work only if it lets it have the lock: the interpreter takes it away from no compiled function.
    ran_within, stepping, done = [], threading.Event(), threading.Event()

    def other():
        while not done.is_set():
            if stepping.is_set():
                ran_within.append(1)
            time.sleep(0)

    thread = threading.Thread(target=other)
    thread.start()
    for i, picture in enumerate(pictures):
        before = len(ran_within)
        stepping.set()
        pipeline.step(picture, t_s=0.1 * i)
        stepping.clear()
        within = len(ran_within) - before
    done.set()
    thread.join()
    assert len(ran_within) > len(pictures), f"another thread ran {len(ran_within)} times in {len(pictures)} steps, {within} in the last"


def test_two_threads_take_turns_in_one_pipeline():
    _, route, camera, drive = scene()
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
    picture = drive[0].picture
    threads = [threading.Thread(target=lambda: [pipeline.step(picture) for _ in range(5)]) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert pipeline.frames == 10


def test_everything_public_has_words():
    for name in fingerpost.__all__:
        value = getattr(fingerpost, name)
        if name == "__version__":
            continue
        assert inspect.getdoc(value), f"{name} has no words"
        if inspect.isclass(value) and not issubclass(value, Exception):
            for member, of_class in vars(value).items():
                if not member.startswith("_"):
                    assert inspect.getdoc(of_class), f"{name}.{member} has no words"


def test_stubs_name_everything():
    stub = (pathlib.Path(fingerpost.__file__).parent / "_fingerpost.pyi").read_text()
    for name in fingerpost.__all__:
        assert f"class {name}" in stub or f"def {name}" in stub or f"{name}:" in stub, name
        value = getattr(fingerpost, name)
        if inspect.isclass(value) and not issubclass(value, Exception):
            for member in vars(value):
                assert member.startswith("_") or f"def {member}(" in stub, f"{name}.{member}"
