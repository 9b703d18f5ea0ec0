"""The compiled part."""

from collections.abc import Callable, Sequence
from typing import Any, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
Matrix = Sequence[Sequence[float]]

def build_pyramid(
    image: ArrayLike,
    kind: str,
    encoding: str,
    alpha: str,
    wrap: tuple[str, str],
    coverage: float | None,
    levels: int | None,
) -> list[NDArray[Any]]: ...
def read_image(path: str) -> NDArray[Any]: ...
def decode_image(name: str, data: bytes) -> NDArray[Any]: ...
def write_image(path: str, image: NDArray[Any]) -> None: ...
def image_info(path: str) -> tuple[str, int, int, int, str]: ...

@final
class Sampling:
    def __new__(
        cls,
        filter: str,
        max_anisotropy: float,
        lod_bias: float,
        lod_rule: str,
        tolerance: float | None,
        seed: int,
        threads: int | None,
    ) -> Self: ...

@final
class Texture:
    def __new__(
        cls,
        image: NDArray[Any],
        wrap: tuple[str, str],
        border: list[float],
        encoding: str,
        alpha: str,
        pyramid: str,
        coverage: float | None,
    ) -> Self: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def channels(self) -> int: ...
    @property
    def dtype(self) -> str: ...
    @property
    def num_levels(self) -> int: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def wrap(self) -> tuple[str, str]: ...
    @property
    def border(self) -> list[float]: ...
    @property
    def encoding(self) -> str: ...
    @property
    def alpha(self) -> str: ...
    @property
    def pyramid(self) -> str: ...
    def level(self, index: int) -> NDArray[Any]: ...
    def sample(
        self,
        uv: NDArray[Any],
        jacobian: NDArray[Any] | None,
        lod: NDArray[Any] | None,
        sampling: Sampling,
        out: NDArray[Any] | None,
    ) -> NDArray[Any]: ...
    def survey(
        self,
        uv: NDArray[Any],
        jacobian: NDArray[Any] | None,
        lod: NDArray[Any] | None,
        sampling: Sampling,
    ) -> NDArray[np.float32]: ...
    def gradient(self, uv: NDArray[Any], filter: str, threads: int | None) -> NDArray[Any]: ...

@final
class SphereTexture:
    def __new__(
        cls,
        image: NDArray[Any],
        form: str,
        layout: str,
        border: list[float],
        encoding: str,
        alpha: str,
        pyramid: str,
    ) -> Self: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def is_cube(self) -> bool: ...
    @property
    def channels(self) -> int: ...
    @property
    def num_levels(self) -> int: ...
    @property
    def nbytes(self) -> int: ...
    def sample(
        self,
        directions: NDArray[Any],
        ddx: NDArray[Any] | None,
        ddy: NDArray[Any] | None,
        lod: NDArray[Any] | None,
        sampling: Sampling,
        out: NDArray[Any] | None,
    ) -> NDArray[Any]: ...

@final
class Warping:
    def __new__(
        cls,
        sampling: Sampling,
        wrap: tuple[str, str],
        border: list[float],
        encoding: str,
        alpha: str,
    ) -> Self: ...

@final
class Places:
    def __new__(
        cls,
        matrix: Matrix | None,
        map_x: NDArray[Any] | None,
        map_y: NDArray[Any] | None,
        period: tuple[float | None, float | None],
    ) -> Self: ...

def warp_image(
    image: NDArray[Any], places: Places, shape: tuple[int, int], warping: Warping, out: NDArray[Any] | None
) -> NDArray[Any]: ...
def warp_coverage(
    image_shape: tuple[int, int], places: Places, shape: tuple[int, int], warping: Warping
) -> NDArray[np.float32]: ...
def warp_survey(
    image: NDArray[Any], places: Places, shape: tuple[int, int], warping: Warping
) -> NDArray[np.float32]: ...
def set_num_threads(threads: int) -> None: ...
def get_num_threads() -> int: ...

@final
class SummedAreaTable:
    def __new__(cls, image: ArrayLike, wrap: tuple[str, str], border: list[float]) -> Self: ...
    def boxes(self, boxes: ArrayLike, mean: bool) -> NDArray[Any]: ...
    def table(self) -> NDArray[Any]: ...
    def offset(self) -> NDArray[Any]: ...
    def wrap(self) -> tuple[str, str]: ...

def interpolate(
    image: NDArray[Any],
    first: NDArray[Any] | None,
    second: NDArray[Any] | None,
    matrix: list[float] | None,
    manner: dict[str, Any],
    out: NDArray[Any],
) -> None: ...
def map_minifies(
    first: NDArray[Any] | None,
    second: NDArray[Any] | None,
    matrix: list[float] | None,
    width: int,
    height: int,
) -> bool: ...
def torch_grid_sample(
    images: Any, grid: Any, mode: str, padding_mode: str, align_corners: bool, last: bool
) -> NDArray[Any] | None: ...
def cv2_remap(
    src: Any,
    map1: Any,
    map2: Any,
    flags: int,
    dst: Any,
    border: int,
    value: Any,
    antialias: bool,
) -> NDArray[Any] | None: ...
def cv2_warp(
    src: Any,
    m: Any,
    rows: int,
    dsize: Any,
    dst: Any,
    flags: int,
    border: int,
    value: Any,
    antialias: bool,
) -> NDArray[Any] | None: ...
def cv2_patch(src: Any, size: Any, center: Any, dst: Any) -> NDArray[Any] | None: ...
def cv2_polar(
    src: Any,
    width: int,
    height: int,
    dsize: tuple[int, int],
    center: tuple[float, float],
    radius: float,
    flags: int,
    dst: Any,
    antialias: bool,
) -> NDArray[Any] | None: ...
def cv2_resize(
    src: Any, dsize: Any, dst: Any, fx: float, fy: float, interpolation: int, antialias: bool
) -> NDArray[Any] | None: ...
def cv2_convert(
    map1: Any, map2: Any, kind: int, dst1: Any, dst2: Any, nearest: bool
) -> tuple[NDArray[Any], NDArray[Any] | None] | None: ...
def cv2_pyramid(
    src: Any, dst: Any, size: Sequence[int] | None, border: int, enlarge: bool
) -> NDArray[Any] | None: ...
def cv2_integral(src: Any, given: tuple[Any, ...], sum_depth: int, square_depth: int) -> Any: ...
def cv2_rectify(
    matrix3: Any, lens: Any, r: Any, new: Any, size: Any, kind: int, map1: Any, map2: Any
) -> tuple[NDArray[Any], NDArray[Any] | None] | None: ...
def cv2_undistort(
    src: Any, matrix3: Any, lens: Any, dst: Any, new: Any, antialias: bool
) -> NDArray[Any] | None: ...
def cv2_undistortion(
    intrinsics: tuple[float, float, float, float],
    lens: list[float],
    inverse: list[float],
    size: tuple[int, int],
    kind: int,
    map1: Any,
    map2: Any,
) -> tuple[NDArray[Any], NDArray[Any] | None] | None: ...

_Planes = tuple[NDArray[np.float64], NDArray[np.float64]]
_Rows = tuple[NDArray[np.int64], NDArray[np.float64]]

def lerp_image(
    image: NDArray[Any],
    matrix: list[float] | None,
    planes: _Planes | None,
    mode: str,
    factor: float,
    border: float,
    nowhere: float,
    limits: tuple[float, float],
    out: NDArray[Any],
) -> None: ...
def nearest_image(
    image: NDArray[Any],
    matrix: list[float] | None,
    planes: _Planes | None,
    mode: str,
    border: NDArray[Any],
    out: NDArray[Any],
) -> None: ...
def resample_image(
    image: NDArray[Any],
    down: _Rows,
    across: _Rows | None,
    mode: str,
    numbers: tuple[float, float, tuple[float, float]],
    out: NDArray[Any],
) -> None: ...
def value_range(array: NDArray[Any]) -> tuple[float, float, bool]: ...

_Triple = tuple[float, float, float]
_Pair = tuple[float, float]

@final
class Mapping:
    @staticmethod
    def planar(axis: str, min: _Triple, max: _Triple) -> Mapping: ...
    @staticmethod
    def facets(min: _Triple, max: _Triple) -> Mapping: ...
    @staticmethod
    def cube(layout: str, center: _Triple) -> Mapping: ...
    @staticmethod
    def spherical(axis: str, center: _Triple) -> Mapping: ...
    @staticmethod
    def cylindrical(axis: str, center: _Triple, height: _Pair) -> Mapping: ...
    @staticmethod
    def linear(a: float, b: float, c: float, d: float, e: float, f: float) -> Mapping: ...
    @staticmethod
    def patch(s: _Pair, t: _Pair, u: _Pair, v: _Pair) -> Mapping: ...
    @staticmethod
    def two_stage(
        intermediate: str,
        projection: str,
        eye: _Triple | None,
        center: _Triple,
        radius: float,
        axis: str,
        height: _Pair,
        layout: str,
    ) -> Mapping: ...
    @staticmethod
    def direction(kind: str) -> Mapping: ...
    @staticmethod
    def stereographic(fov: float) -> Mapping: ...
    @staticmethod
    def fisheye(model: str, fov: float) -> Mapping: ...
    @staticmethod
    def perspective(fov: float, aspect: float) -> Mapping: ...
    @staticmethod
    def projective(rows: list[list[float]], back_faces: bool) -> Mapping: ...
    @staticmethod
    def polygon(corners: list[list[float]], uv: list[list[float]]) -> Mapping: ...
    @property
    def dimensions(self) -> int: ...
    @property
    def has_inverse(self) -> bool: ...
    @property
    def needs_normals(self) -> bool: ...
    def apply(
        self,
        points: NDArray[Any],
        normals: NDArray[Any] | None,
        dpdx: NDArray[Any] | None,
        dpdy: NDArray[Any] | None,
        dndx: NDArray[Any] | None,
        dndy: NDArray[Any] | None,
    ) -> tuple[NDArray[Any], NDArray[Any] | None]: ...
    def inverse(self, uv: NDArray[Any]) -> NDArray[Any]: ...

@final
class Surface:
    @staticmethod
    def sphere(radius: float, center: _Triple) -> Surface: ...
    @staticmethod
    def cylinder(radius: float, height: _Pair, center: _Triple) -> Surface: ...
    @staticmethod
    def torus(major: float, minor: float, center: _Triple) -> Surface: ...
    @staticmethod
    def bezier(control: list[list[list[float]]]) -> Surface: ...
    def at(self, uv: NDArray[Any]) -> NDArray[Any]: ...

def linear_inverse(a: float, b: float, c: float, d: float, e: float, f: float) -> list[float]: ...
def checkerboard(uv: NDArray[Any], cells: _Pair, jacobian: NDArray[Any] | None) -> NDArray[Any]: ...
def barycentric(points: NDArray[Any], triangle: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]: ...
def distortion(jacobian: NDArray[Any]) -> NDArray[Any]: ...
def tangents(normals: NDArray[Any]) -> NDArray[Any]: ...

@final
class Camera:
    def __new__(
        cls,
        eye: list[float],
        target: list[float],
        up: list[float],
        yfov_rad: float,
        near: float,
        far: float,
    ) -> Self: ...
    @property
    def name(self) -> str: ...
    @property
    def eye(self) -> list[float]: ...
    def view(self) -> NDArray[np.float64]: ...
    def matrix(self, size: tuple[int, int]) -> NDArray[np.float64]: ...
    def project(self, points: ArrayLike, size: tuple[int, int]) -> NDArray[np.float64]: ...
    @staticmethod
    def framing(positions: ArrayLike, faces: ArrayLike, aspect: float) -> Camera: ...
    def turned(self, center: list[float], angle_rad: float) -> Camera: ...

_Vector = tuple[float, float, float]
_Light = tuple[str, _Vector, _Vector, float | None, tuple[_Vector, tuple[float, float]] | None]

def open_scene(path: str, normals: str) -> tuple[dict[str, Any], list[Camera], list[_Light]]: ...
def build_mesh(
    positions: ArrayLike,
    faces: ArrayLike,
    normals: ArrayLike | None,
    uv_sets: list[ArrayLike],
    colors: ArrayLike | None,
    missing: str,
) -> dict[str, Any]: ...

@final
class Textures:
    def __new__(cls) -> Self: ...

@final
class Drawing:
    def __new__(cls, parts: dict[str, Any]) -> Self: ...
    def render(
        self,
        textures: Textures,
        camera: Camera,
        lights: list[_Light] | None,
        size: tuple[int, int],
        sampling: Sampling,
        file_filters: bool,
        environment: Environment | None,
        background: tuple[float, float, float, float],
        show_environment: bool,
        shadows: tuple[int, float] | None,
        bump_curvature: bool,
        displacement_edge_px: float,
        supersample: int,
        debug: str | None,
        report: bool,
        linear: bool,
        progress: Callable[[float], object] | None,
    ) -> tuple[NDArray[Any], list[Any]]: ...

@final
class Environment:
    def __new__(
        cls,
        image: ArrayLike,
        form: str,
        layout: str,
        encoding: str,
        yaw_rad: float,
        intensity: float,
    ) -> Self: ...
    def diffuse(self, normals: ArrayLike) -> NDArray[np.float32]: ...
    def radiance(
        self,
        directions: ArrayLike,
        moving: ArrayLike | None,
        exponent: float,
        sampling: Sampling,
    ) -> NDArray[np.float32]: ...

def bumped_normals(
    p_u: ArrayLike,
    p_v: ArrayLike,
    normals: ArrayLike,
    slopes: ArrayLike,
    heights: ArrayLike | None,
    n_u: ArrayLike | None,
    n_v: ArrayLike | None,
) -> NDArray[np.float32]: ...
def cast_rays(
    positions: ArrayLike,
    faces: ArrayLike,
    origins: ArrayLike,
    directions: ArrayLike,
    threads: int | None,
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]: ...
def closest_points(
    positions: ArrayLike, faces: ArrayLike, points: ArrayLike, threads: int | None
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]: ...
def uv_layout(
    uv: ArrayLike, faces: ArrayLike, size: tuple[int, int], samples: int
) -> tuple[int, int, NDArray[np.uint32]]: ...
def simplify_mesh(mesh: object, ratio: float) -> dict[str, Any]: ...

@final
class Baked:
    def image(self, dtype: str, encoding: str, range: tuple[float, float] | None) -> NDArray[Any]: ...
    def range(self) -> tuple[float, float] | None: ...
    def coverage(self) -> NDArray[np.float32]: ...
    def flags(self) -> NDArray[np.uint8]: ...
    def report(self) -> tuple[dict[str, Any], list[str]]: ...

def bake_map(
    high: object,
    low: object,
    size: tuple[int, int],
    what: str,
    space: str,
    rays: int,
    radius: float,
    paints: list[tuple[list[float], Texture | None, int, list[list[float]]]],
    samples: int,
    method: str,
    distance: float | None,
    cage: ArrayLike | None,
    padding: int | None,
    threads: int | None,
    progress: Callable[[float], object] | None,
) -> Baked: ...
def vertex_normals(positions: ArrayLike, faces: ArrayLike) -> NDArray[np.float32]: ...

@final
class Fragments:
    @property
    def size(self) -> tuple[int, int]: ...
    def behind(self, cull: str, back_of: NDArray[np.bool_] | None, samples: int) -> Fragments: ...
    def triangle(self) -> NDArray[np.int32]: ...
    def depth(self) -> NDArray[np.float32]: ...
    def coverage(self) -> NDArray[np.float32]: ...
    def barycentric(self) -> NDArray[np.float32]: ...
    def interpolate(
        self, attributes: NDArray[Any], derivatives: bool, fill: float
    ) -> tuple[NDArray[Any], NDArray[Any] | None]: ...

def rasterize(
    clip_positions: ArrayLike,
    faces: ArrayLike,
    size: tuple[int, int],
    cull: str,
    back_of: NDArray[np.bool_] | None,
    samples: int,
    threads: int | None,
) -> Fragments: ...
def reference_sample(
    image: ArrayLike,
    uv: ArrayLike,
    jacobian: ArrayLike | None,
    description: tuple[str, str, list[float], str, str, str],
    filter: tuple[str, float],
    tolerance: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def reference_quad(
    image: ArrayLike,
    corners: ArrayLike,
    description: tuple[str, str, list[float], str, str, str],
) -> NDArray[np.float64]: ...
def reference_warp(
    image: ArrayLike,
    matrix: list[list[float]] | None,
    mapping: Callable[..., Any] | None,
    shape: tuple[int, int],
    description: tuple[str, str, list[float], str, str, str],
    filter: tuple[str, float],
    tolerance: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

_Form = tuple[str, str, str, float | None]

def panorama_convert(
    image: NDArray[Any],
    source: _Form,
    target: _Form,
    size: tuple[int, int],
    rotation: list[list[float]],
    warping: Warping,
    progress: Callable[[float], object] | None,
) -> NDArray[Any]: ...
