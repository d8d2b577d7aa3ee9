"""Single-camera navigation localisation: the junctions of a route found in the picture, followed, and a driving line through them.

A camera, a route and frames in; where the next junction is, how sure that is and why, out::

    roads, route = fingerpost.demo_town()
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
    output = pipeline.step(frame, t_s=0.0)

Lengths are in metres, angles in radians unless a name ends in ``_deg``, times in seconds from the first frame. The vehicle's frame has
x forward, y left and z up, on the road below the rear axle's middle.
"""

from ._fingerpost import (
    Camera,
    CameraError,
    ConfigError,
    EvaluationError,
    FingerpostError,
    FrameError,
    MapError,
    Output,
    Pipeline,
    RoadMap,
    Route,
    SimulatedFrame,
    SimulationError,
    Simulator,
    __version__,
    conditions,
    config_schema,
    demo_town,
    evaluate_junctions,
    evaluate_lanes,
)

__all__ = [
    "Camera",
    "CameraError",
    "ConfigError",
    "EvaluationError",
    "FingerpostError",
    "FrameError",
    "MapError",
    "Output",
    "Pipeline",
    "RoadMap",
    "Route",
    "SimulatedFrame",
    "SimulationError",
    "Simulator",
    "__version__",
    "conditions",
    "config_schema",
    "demo_town",
    "evaluate_junctions",
    "evaluate_lanes",
]
