"""What the compiled part of the package holds."""

from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from typing import Any, Literal

import numpy
from numpy.typing import NDArray

__version__: str

class FingerpostError(Exception):
    """What went wrong, and what to do about it."""

class CameraError(FingerpostError):
    """A calibration cannot be used."""

class ConfigError(FingerpostError):
    """A setting is unknown or out of range."""

class MapError(FingerpostError):
    """A map or route cannot be used."""

class FrameError(FingerpostError):
    """A frame cannot be used; the pipeline is as before it."""

class SimulationError(FingerpostError):
    """A drive cannot be simulated."""

class EvaluationError(FingerpostError):
    """Records and truth do not fit together."""

class Camera:
    """A calibrated camera on its mount.

    Focal lengths and principal point are in pixels, the top-left pixel's centre is (0, 0). ``height_m`` is above the road,
    ``pitch_deg`` positive nose down, ``yaw_deg`` positive to the left, ``roll_deg`` positive left side up, ``x_m`` forward of the
    rear axle, ``y_m`` left of the centre line. ``distortion`` is "none", "brown-conrady" or "kannala-brandt", its coefficients in
    OpenCV's order. Raises CameraError where the numbers cannot be those of a camera.
    """

    def __init__(
        self,
        width: int,
        height: int,
        *,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        height_m: float,
        pitch_deg: float = 0.0,
        yaw_deg: float = 0.0,
        roll_deg: float = 0.0,
        x_m: float = 0.0,
        y_m: float = 0.0,
        distortion: Literal["none", "brown-conrady", "kannala-brandt"] = "none",
        coefficients: Sequence[float] = (),
    ) -> None: ...
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Camera:
        """Reads camera.toml, or the YAML of ROS camera_info or OpenCV with a mount.toml beside it."""
    @staticmethod
    def from_toml(text: str) -> Camera:
        """The camera of a text as in camera.toml."""
    @staticmethod
    def from_yaml(text: str) -> Camera:
        """The camera of a YAML text with a mapping ``mount`` in it."""
    def to_toml(self) -> str:
        """The text of its camera.toml."""
    @property
    def width(self) -> int:
        """Width of its pictures, pixels."""
    @property
    def height(self) -> int:
        """Height of its pictures, pixels."""
    def pixel_of_ground(self, x_m: float, y_m: float) -> tuple[float, float] | None:
        """Where a place on the road, metres forward and left, is in the picture: right and down, pixels; None behind the camera."""
    def ground_of_pixel(self, u: float, v: float) -> tuple[float, float] | None:
        """Which place on the road a pixel shows, metres forward and left; None above the horizon."""
    def scaled_to(self, width: int, height: int) -> Camera:
        """The camera of pictures made smaller or larger."""

class RoadMap:
    """The roads of an OpenStreetMap extract."""

    @staticmethod
    def from_file(path: str | PathLike[str]) -> RoadMap:
        """Reads .osm (XML) or .osm.pbf. Raises MapError."""
    def plan(self, places: Sequence[tuple[float, float]]) -> Route:
        """The shortest route through places, latitude and longitude in degrees. Raises MapError."""
    def match_track(self, track: Sequence[tuple[float, float]]) -> Route:
        """The route that was driven along a track, latitude and longitude in degrees. Raises MapError."""

class Route:
    """A route with the features that are looked for on it."""

    @staticmethod
    def from_file(path: str | PathLike[str]) -> Route:
        """Reads a route file, as ``fingerpost route`` writes it. Raises MapError."""
    @staticmethod
    def from_geojson(text: str) -> Route:
        """The route of a text as in route.geojson. Raises MapError."""
    def to_geojson(self) -> str:
        """The text of its route.geojson."""
    @property
    def length_m(self) -> float:
        """Its length, metres."""
    @property
    def features(self) -> list[dict[str, Any]]:
        """Its features in their order: ``id``, ``name``, ``kind``, ``route_m``, ``turn_deg``."""
    @property
    def line_m(self) -> list[tuple[float, float]]:
        """Its points, metres east and north of the first."""

class Pipeline:
    """The method with its state.

    ``start_m`` is the vehicle's distance along the route at the first frame, where it is known. ``config`` is the text of a
    fingerpost.toml. With ``roads`` every frame says where the vehicle is on the map, known to be near ``near`` (latitude and longitude,
    degrees) or anywhere. The detector "onnx" is not in this package. Raises CameraError or ConfigError.
    """

    def __init__(
        self,
        camera: Camera,
        route: Route | None = None,
        *,
        start_m: float | None = None,
        config: str | None = None,
        roads: RoadMap | None = None,
        near: tuple[float, float] | None = None,
    ) -> None: ...
    def step(
        self,
        frame: NDArray[numpy.uint8],
        t_s: float | None = None,
        *,
        gps: tuple[float, float] | None = None,
        speed_mps: float | None = None,
        yaw_rate_rps: float | None = None,
    ) -> Output:
        """Takes one frame in: height, width and red, green, blue.

        ``t_s`` are seconds since the first frame, ``gps`` latitude and longitude in degrees, ``speed_mps`` and ``yaw_rate_rps`` (positive
        to the left) what the vehicle's own sensors say. The frame is copied once and the interpreter's lock released while the method
        works. Raises FrameError, and the pipeline is as before the frame.
        """
    @property
    def frames(self) -> int:
        """How many frames were taken in."""
    def config(self) -> str:
        """The settings in force, TOML."""

class Output:
    """What the method says of a frame, and what it saw. Arrays are new with every access, and the caller's own."""

    @property
    def record(self) -> dict[str, Any]:
        """What the program writes as a line of frames.jsonl; its ``stage_ms`` is empty."""
    @property
    def state(self) -> Literal["searching", "tracking", "arrived", "lost", "route_done", "no_route"]:
        """What is done about the route's next feature."""
    @property
    def feature(self) -> dict[str, Any] | None:
        """The followed feature; None where there is none."""
    @property
    def advice(self) -> dict[str, Any]:
        """Steering angle and speed for a controller, and why."""
    @property
    def why(self) -> str:
        """What was decided and what decided it."""
    @property
    def ground_view(self) -> NDArray[numpy.uint8]:
        """The view from above, far up: rows, columns, and red, green, blue."""
    @property
    def ground_validity(self) -> NDArray[numpy.uint8]:
        """Where the camera shows the road's plane: 1, else 0."""
    @property
    def road_surface(self) -> NDArray[numpy.uint8]:
        """How probable road is in the view from above, 255 for 1."""
    @property
    def road_known(self) -> NDArray[numpy.uint8]:
        """Where that is known, seen or remembered: 1, else 0."""
    @property
    def driving_line(self) -> NDArray[numpy.float64]:
        """The driving line: points forward and left of the vehicle, metres."""

class Simulator(Sequence[SimulatedFrame]):
    """A vehicle on a map's roads, seen by its camera: a sequence of frames, rendered when they are asked for.

    The same seed gives the same bytes. Raises SimulationError.
    """

    def __init__(
        self,
        roads: RoadMap,
        route: Route,
        camera: Camera,
        *,
        seed: int = 1,
        conditions: str = "clear",
        fps: float = 10.0,
        frames: int | None = None,
        traffic: Literal["left", "right", "centre"] = "right",
    ) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> SimulatedFrame: ...  # type: ignore[override]
    def __iter__(self) -> Iterator[SimulatedFrame]: ...

class SimulatedFrame:
    """A frame of a simulated drive."""

    @property
    def picture(self) -> NDArray[numpy.uint8]:
        """What the camera sees: rows, columns, and red, green, blue."""
    @property
    def road_mask(self) -> NDArray[numpy.uint8]:
        """Where road is in it: 255, else 0."""
    @property
    def truth(self) -> dict[str, Any]:
        """What is true of it, as a line of truth.jsonl."""

def demo_town() -> tuple[RoadMap, Route]:
    """The town of the demonstration and a kilometre through it. Map data (c) OpenStreetMap contributors, ODbL 1.0."""

def conditions() -> list[str]:
    """Names of the conditions that drives can be simulated under."""

def config_schema() -> dict[str, Any]:
    """The JSON Schema of the settings: every key with its unit, range and default."""

def evaluate_junctions(
    records: Iterable[dict[str, Any]], truth: Iterable[dict[str, Any]], route: Route
) -> dict[str, Any]:
    """What a run found of a route's features and how far off it put them, by its records and the truth. Raises EvaluationError."""

def evaluate_lanes(
    records: Iterable[dict[str, Any]], truth: Iterable[dict[str, Any]], picture_px: tuple[int, int]
) -> dict[str, Any]:
    """How near the lane edges of a run are to those of the truth. Raises EvaluationError."""

class Search:
    """A search of settings by NSGA-II; ``fingerpost.fleet.tune`` does its trials.

    Of ``keys`` each is a number of the settings with its range. Raises ConfigError.
    """

    def __init__(
        self, keys: Sequence[tuple[str, float, float]], *, config: str | None = None, population: int = 10, seed: int = 1
    ) -> None: ...
    def ask(self) -> list[tuple[dict[str, float], str]]:
        """The next generation, the same until it is told of: of each trial its values, and the whole configuration as TOML."""
    def tell(self, objectives: Sequence[Sequence[float]]) -> None:
        """What came of each trial of the generation; everything is to be small. Raises ConfigError."""

def front(objectives: Sequence[Sequence[float]]) -> list[int]:
    """Which points no other beats in everything, by their numbers."""
