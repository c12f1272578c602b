"""The scenes of scenes.toml, and the geometry that every renderer derives its own scene from."""

import math
import tomllib
from dataclasses import asdict, dataclass, replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[2]

Vector = tuple[float, float, float]


def subtract(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Vector, factor: float) -> Vector:
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a: Vector) -> Vector:
    return scale(a, 1 / math.hypot(*a))


@dataclass(frozen=True)
class Camera:
    """A pinhole; `fov` in degrees across the width."""

    position: Vector
    target: Vector
    fov: float


@dataclass(frozen=True)
class Box:
    """A box along the axes, by two opposite corners."""

    low: Vector
    high: Vector

    def holds(self, point: Vector) -> bool:
        return all(a < p < b for a, p, b in zip(self.low, point, self.high))


@dataclass(frozen=True)
class Volume:
    """A density grid of a VDB file, or fog of density 1 in a box; `sigma_t` in 1/m for density 1."""

    within: Path | Box
    sigma_t: float
    albedo: float
    g: float
    grid: str = "density"


@dataclass(frozen=True)
class Quad:
    """A square with half edges `u` and `v`; its front is where u x v points."""

    center: Vector
    u: Vector
    v: Vector

    @property
    def normal(self) -> Vector:
        return normalize(cross(self.u, self.v))

    @property
    def area(self) -> float:
        return 4 * math.hypot(*cross(self.u, self.v))

    @property
    def corners(self) -> list[Vector]:
        """Counter-clockwise as seen from the front."""
        return [
            tuple(self.center[i] + a * self.u[i] + b * self.v[i] for i in range(3))
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]


@dataclass(frozen=True)
class AreaLight:
    quad: Quad
    radiance: float


@dataclass(frozen=True)
class Ground:
    quad: Quad
    reflectance: float


@dataclass(frozen=True)
class Sun:
    """Parallel light; `direction` is the way it travels, `irradiance` on a plane square to it."""

    direction: Vector
    irradiance: float


@dataclass(frozen=True)
class GivenReference:
    """A reference that need not be rendered, and the relative MSE of its noise."""

    file: Path
    noise: float


@dataclass(frozen=True)
class Scene:
    name: str
    title: str
    about: str
    size: int
    camera: Camera
    volume: Volume
    area_light: AreaLight | None
    ground: Ground | None
    sun: Sun | None
    sky: float
    reference: GivenReference | None
    # Rays of its own reference over those of a budget.
    reference_effort: int

    @property
    def content(self) -> dict:
        """What decides the picture, for telling whether a stored one is still that of the scene."""
        words = ("title", "about", "reference", "reference_effort")
        return {key: value for key, value in asdict(self).items() if key not in words}


def facing(center: Vector, target: Vector, half: float) -> Quad:
    """A square that looks at `target`, two of its edges level."""
    normal = normalize(subtract(target, center))
    up = (0.0, 1.0, 0.0) if abs(normal[1]) < 1.0 else (0.0, 0.0, 1.0)
    u = normalize(cross(up, normal))
    return Quad(center, scale(u, half), scale(cross(normal, u), half))


def level(center: Vector, half: float) -> Quad:
    """A square that looks up."""
    return Quad(center, (0.0, 0.0, half), (half, 0.0, 0.0))


def _area_light(table: dict) -> AreaLight:
    quad = facing(tuple(table["center"]), tuple(table["target"]), table["half"])
    return AreaLight(quad, table["radiance"])


def _ground(table: dict) -> Ground:
    return Ground(level(tuple(table["center"]), table["half"]), table["reflectance"])


def _sun(table: dict) -> Sun:
    return Sun(normalize(tuple(table["direction"])), table["irradiance"])


def _scene(name: str, table: dict) -> Scene:
    camera, volume, reference = table["camera"], table["volume"], table.get("reference")
    title = table["title"]
    if "box" in volume:
        within = Box(*(tuple(corner) for corner in volume["box"]))
    else:
        within = (REPOSITORY / volume["file"]).resolve()
        if not within.exists() and "stand_in" in table:
            volume = volume | table["stand_in"]
            within = REPOSITORY / volume["file"]
            title, reference = f"{title} (stand-in {volume['file']})", None
        if not within.exists():
            raise SystemExit(
                f"{name}: {within} is missing; put it there, or leave this scene out with --scene"
            )
    return Scene(
        name=name,
        title=title,
        about=table["about"],
        size=table["size"],
        camera=Camera(tuple(camera["position"]), tuple(camera["target"]), camera["fov"]),
        volume=Volume(within, volume["sigma_t"], volume["albedo"], volume["g"]),
        area_light=_area_light(table["area_light"]) if "area_light" in table else None,
        ground=_ground(table["ground"]) if "ground" in table else None,
        sun=_sun(table["sun"]) if "sun" in table else None,
        sky=table.get("sky", 0.0),
        reference=_given(reference),
        reference_effort=table.get("reference_effort", 1),
    )


def _given(table: dict | None) -> GivenReference | None:
    if table is None or not (REPOSITORY / table["file"]).exists():
        return None
    return GivenReference((REPOSITORY / table["file"]).resolve(), table["noise"])


def names() -> list[str]:
    """The scenes there are."""
    return list(tomllib.loads((HERE / "scenes.toml").read_text()))


def load(name: str, size: int | None = None) -> Scene:
    """The scene `name`; at another `size` than its own, in pixels, without its reference."""
    scene = _scene(name, tomllib.loads((HERE / "scenes.toml").read_text())[name])
    if size is None or size == scene.size:
        return scene
    return replace(scene, size=size, reference=None)
